// What a visitor takes home: the pieces as glTF, and the recording as a film.
import type { LiveFootage } from "./live";
import { scene } from "./pieces";

/**
 * The film is drawn in real time, at about this rate [bit/s]: a wall in 1280 x 720 keeps its edges.
 */
const BITS = 8e6;

/** The bodies of a frame, where they are then, as binary glTF in metres; y is up. */
export async function piecesAsGltf(footage: LiveFootage, frame: number): Promise<Blob> {
  const { GLTFExporter } = await import("three/examples/jsm/exporters/GLTFExporter.js");
  const content = await new GLTFExporter().parseAsync(scene(footage, frame), { binary: true });
  return new Blob([content as ArrayBuffer], { type: "model/gltf-binary" });
}

/** The kind of film that this browser can make; `null` for none. */
export function filmKind(canvas: HTMLCanvasElement): string | null {
  if (typeof MediaRecorder === "undefined" || typeof canvas.captureStream !== "function")
    return null;
  const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
  return kinds.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? null;
}

/** What a canvas shows while something plays. */
export async function film(
  canvas: HTMLCanvasElement,
  kind: string,
  play: () => Promise<void>,
): Promise<Blob> {
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
