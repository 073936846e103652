// What is under the pointer, and what a line over the picture crosses. Needs no browser.
import { Quaternion, Ray, Vector3 } from "three";
import type { LiveFootage } from "./live";

/** A ray in the world frame. */
export interface Sight {
  origin: Vector3;
  direction: Vector3;
}

export interface Hit {
  body: number;
  name: string;
  /** [kg]; 0 for what does not move by itself. */
  mass: number;
  /** World frame, and the body's [m]. */
  point: Vector3;
  pointBody: Vector3;
  distance: number;
}

/** The nearest body of a frame on a ray; half-spaces are looked through. */
export function pick(
  footage: LiveFootage,
  frame: number,
  { origin, direction }: Sight,
): Hit | null {
  let nearest: Hit | null = null;
  const state = footage.state(frame);
  const corners = [new Vector3(), new Vector3(), new Vector3()] as const;
  state.ids.forEach((id, row) => {
    const body = footage.body(id);
    if (body === undefined || body.floor) return;
    const { positions, triangles } = footage.meshes[body.mesh]!;
    const place = new Vector3().fromArray(state.poses, 7 * row);
    const turn = new Quaternion().fromArray(state.poses, 7 * row + 3);
    const back = turn.clone().invert();
    const ray = new Ray(
      origin.clone().sub(place).applyQuaternion(back),
      direction.clone().applyQuaternion(back),
    );
    if (ray.distanceSqToPoint(new Vector3()) > footage.radius(body.mesh) ** 2) return;
    for (let i = 0; i < triangles.length; i += 3) {
      corners.forEach((corner, k) => corner.fromArray(positions, 3 * triangles[i + k]!));
      const found = ray.intersectTriangle(...corners, true, new Vector3());
      if (found === null) continue;
      const distance = found.distanceTo(ray.origin);
      if (nearest !== null && distance >= nearest.distance) continue;
      const point = found.clone().applyQuaternion(turn).add(place);
      nearest = { body: id, name: body.name, mass: body.mass, point, pointBody: found, distance };
    }
  });
  return nearest;
}

/** Looks along a line over the picture: one so often finds pieces of a hundredth of its width. */
const LOOKS = 100;

/**
 * The bodies that a line over the picture crosses, those that can move; and across its plane, which
 * holds the eye.
 */
export function crossed(
  footage: LiveFootage,
  frame: number,
  from: Sight,
  to: Sight,
): { bodies: number[]; normal: Vector3 } {
  const bodies = new Set<number>();
  for (let look = 0; look <= LOOKS; look++) {
    const direction = from.direction
      .clone()
      .lerp(to.direction, look / LOOKS)
      .normalize();
    const hit = pick(footage, frame, { origin: from.origin, direction });
    if (hit !== null && hit.mass > 0) bodies.add(hit.body);
  }
  return { bodies: [...bodies], normal: from.direction.clone().cross(to.direction) };
}
