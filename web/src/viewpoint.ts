// Where it is seen from, moved by keys: turned, pulled nearer, moved aside, and pointed at a body.
import { Spherical, Vector3, type PerspectiveCamera } from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/** Of one press [radians], and of the distance. */
const TURN = Math.PI / 24;
const ASIDE = 0.06;
const NEARER = 0.88;
/** A body that is focused fills about so much of the height. */
const FILLED = 0.3;

export class Viewpoint {
  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly orbit: OrbitControls,
  ) {}

  /** Around what it looks at, to the right and up. */
  turn(right: number, up: number): void {
    const { camera, orbit } = this;
    const way = new Spherical().setFromVector3(camera.position.clone().sub(orbit.target));
    way.theta += TURN * right;
    way.phi = Math.min(Math.max(way.phi - TURN * up, 0.02), orbit.maxPolarAngle);
    camera.position.setFromSpherical(way).add(orbit.target);
    camera.lookAt(orbit.target);
  }

  /** Nearer by a step, or away from it. */
  zoom(nearer: boolean): void {
    const distance = this.camera.position.distanceTo(this.orbit.target);
    this.place(this.orbit.target, distance * (nearer ? NEARER : 1 / NEARER));
  }

  /** Look further to the right and up. */
  move(right: number, up: number): void {
    const { camera, orbit } = this;
    const step = ASIDE * camera.position.distanceTo(orbit.target);
    const aside = new Vector3(right, up, 0).applyQuaternion(camera.quaternion).multiplyScalar(step);
    camera.position.add(aside);
    orbit.target.add(aside);
  }

  /** Look at a ball, from the same side. */
  focus(middle: Vector3, radius: number): void {
    this.place(middle, radius / FILLED / Math.tan((this.camera.fov * Math.PI) / 360));
  }

  private place(target: Vector3, distance: number): void {
    const { camera, orbit } = this;
    const way = camera.position.clone().sub(orbit.target).normalize();
    const length = Math.min(Math.max(distance, orbit.minDistance), orbit.maxDistance);
    orbit.target.copy(target);
    camera.position.copy(target).addScaledVector(way, length);
  }
}
