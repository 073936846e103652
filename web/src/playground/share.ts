// A story as text for a link, and back: what reads it ends in the same bits.
import type { Story } from "./protocol";

/** A longer link is refused by some of the programs that links go through [characters]. */
export const LONGEST = 60_000;

/** A longer story is not opened: a link must not simulate for ever [frames]. */
export const MOST_FRAMES = 36_000;

/** A larger story is not unpacked: it is many times that of ten minutes [bytes of JSON]. */
export const MOST_BYTES = 16 * 1024 * 1024;

/** Deflated JSON in base64 with characters that links may have. */
export async function encode(story: Story): Promise<string> {
  const bytes = new TextEncoder().encode(JSON.stringify(story));
  const packed = await through(bytes, new CompressionStream("deflate-raw"));
  let text = "";
  for (const byte of packed) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Throws for text that is no story. */
export async function decode(text: string): Promise<Story> {
  const packed = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (part) =>
    part.charCodeAt(0),
  );
  const story: unknown = JSON.parse(
    new TextDecoder().decode(
      await through(packed, new DecompressionStream("deflate-raw"), MOST_BYTES),
    ),
  );
  if (!isStory(story)) throw new Error("no story");
  return story;
}

function isStory(value: unknown): value is Story {
  const { scene, actions } = (value ?? {}) as Partial<Story>;
  return typeof scene === "string" && Array.isArray(actions) && actions.every(isAction);
}

const DEEDS = ["add", "hold", "letGo", "cut", "burst"];

/** The engine checks the rest when it is done. */
function isAction(value: unknown): boolean {
  const { frame, ...deed } = (value ?? {}) as { frame?: unknown };
  const [name, ...more] = Object.keys(deed);
  return (
    Number.isSafeInteger(frame) &&
    (frame as number) >= 0 &&
    (frame as number) <= MOST_FRAMES &&
    name !== undefined &&
    more.length === 0 &&
    DEEDS.includes(name) &&
    isDeed(Object.values(deed)[0], name)
  );
}

function isDeed(value: unknown, name: string): boolean {
  if (name === "letGo") return typeof value === "number";
  if (typeof value !== "object" || value === null) return false;
  const isVector = (part: unknown): boolean =>
    Array.isArray(part) && part.length === 3 && part.every((number) => typeof number === "number");
  return (
    name === "add" ||
    Object.entries(value).every(([key, part]) =>
      key === "point" || key === "target" || key === "normal"
        ? isVector(part)
        : typeof part === "number",
    )
  );
}

/** Throws as soon as more than `most` bytes come out. */
async function through(
  bytes: Uint8Array<ArrayBuffer>,
  stream: CompressionStream | DecompressionStream,
  most = Infinity,
): Promise<Uint8Array> {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let length = 0;
  const counted = new WritableStream<Uint8Array<ArrayBuffer>>({
    write(part) {
      length += part.length;
      if (length > most) throw new Error("a story that is too long");
      parts.push(part);
    },
  });
  await new Response(bytes).body!.pipeThrough(stream).pipeTo(counted);
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}
