// The bodies of a frame as a scene of three.js. Needs no browser.
import { BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshStandardMaterial } from "three";
import type { LiveFootage } from "./live";

/** How rough a surface without a roughness of its own is: that of the page's light. */
const ROUGHNESS = 0.8;

/** Where they are then, in metres, y up; half-spaces are left out. */
export function scene(footage: LiveFootage, frame: number): Group {
  const materials = footage.materials.map(({ name, colour, metallic, clear, roughness }) => {
    const look = new MeshStandardMaterial({
      name,
      color: new Color(...colour),
      metalness: metallic,
      roughness: roughness < 0 ? ROUGHNESS : roughness,
    });
    if (clear > 0) [look.transparent, look.opacity] = [true, 1 - clear];
    return look;
  });
  const group = new Group();
  const state = footage.state(frame);
  state.ids.forEach((id, row) => {
    const body = footage.body(id);
    if (body === undefined || body.floor) return;
    const { positions, normals, triangles, slots } = footage.meshes[body.mesh]!;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    // The triangles of each material in a row.
    const index: number[] = [];
    body.materials.forEach((material, slot) => {
      const first = index.length;
      for (let i = 0; i < triangles.length; i += 3)
        if (slots[triangles[i]!] === slot) index.push(...triangles.subarray(i, i + 3));
      if (index.length > first) geometry.addGroup(first, index.length - first, material);
    });
    geometry.setIndex(index);
    const mesh = new Mesh(geometry, materials);
    mesh.name = body.name;
    mesh.position.fromArray(state.poses, 7 * row);
    mesh.quaternion.fromArray(state.poses, 7 * row + 3);
    group.add(mesh);
  });
  return group;
}
