// What a visitor takes home: the pieces as glTF, and the recording as a film.
import { BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshStandardMaterial } from "three";
import type { LiveFootage } from "./live";

/** The film is drawn in real time, at about this rate [bit/s]: a wall in 1280 x 720 keeps its edges. */
const BITS = 8e6;

/** The bodies of a frame, where they are then, as binary glTF in metres; y is up. */
export async function piecesAsGltf(footage: LiveFootage, frame: number): Promise<Blob> {
  const { GLTFExporter } = await import("three/examples/jsm/exporters/GLTFExporter.js");
  const content = await new GLTFExporter().parseAsync(scene(footage, frame), { binary: true });
  return new Blob([content as ArrayBuffer], { type: "model/gltf-binary" });
}

/** The same as a scene of three.js; half-spaces are left out. */
export function scene(footage: LiveFootage, frame: number): Group {
  const materials = footage.materials.map(({ name, colour, metallic, clear, roughness }) => {
    const look = new MeshStandardMaterial({ name, color: new Color(...colour), metalness: metallic, roughness: roughness < 0 ? 0.8 : roughness });
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
      for (let i = 0; i < triangles.length; i += 3) if (slots[triangles[i]!] === slot) index.push(...triangles.subarray(i, i + 3));
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

/** The kind of film that this browser can make; `null` for none. */
export function filmKind(canvas: HTMLCanvasElement): string | null {
  if (typeof MediaRecorder === "undefined" || typeof canvas.captureStream !== "function") return null;
  const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
  return kinds.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? null;
}

/** What a canvas shows while something plays. */
export async function film(canvas: HTMLCanvasElement, kind: string, play: () => Promise<void>): Promise<Blob> {
  const stream = canvas.captureStream();
  const recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: BITS });
  const parts: Blob[] = [];
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  const stopped = new Promise((done) => recorder.addEventListener("stop", done));
  recorder.start();
  await play();
  recorder.stop();
  await stopped;
  for (const track of stream.getTracks()) track.stop();
  return new Blob(parts, { type: kind.split(";")[0]! });
}

/** Hands a file to the visitor. */
export function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  // The browser has it by then [ms].
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
