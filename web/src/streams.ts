// The blob that `python/frangible/io/page_data.py` describes: a header, and streams of whole
// numbers.

/** A stream as the header describes it. */
export interface StreamInfo {
  offset: number;
  rows: number;
  columns: number;
  bytes: number;
  order: number;
}

/** A blob after inflation. */
export class Blob32 {
  readonly header: Record<string, unknown>;
  private readonly streams: Record<string, StreamInfo>;
  private readonly bytes: Uint8Array;

  constructor(blob: Uint8Array) {
    const length = new DataView(blob.buffer, blob.byteOffset).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(blob.subarray(4, 4 + length))) as Record<
      string,
      unknown
    >;
    this.header = header;
    this.streams = header["streams"] as Record<string, StreamInfo>;
    this.bytes = blob.subarray(4 + length);
  }

  /** The columns of a stream. */
  columns(name: string): Int32Array[] {
    const info = this.streams[name];
    if (info === undefined) throw new Error(`the recording has no ${name}`);
    return decode(this.bytes, info);
  }

  /** A stream of one column. */
  column(name: string): Int32Array {
    return this.columns(name)[0] ?? new Int32Array(0);
  }
}

/** Whole numbers, column by column. */
export function decode(
  bytes: Uint8Array,
  { offset, rows, columns, bytes: width, order }: StreamInfo,
): Int32Array[] {
  const count = rows * columns;
  const folded = new Int32Array(count);
  for (let plane = 0; plane < width; plane++) {
    const start = offset + plane * count;
    for (let i = 0; i < count; i++) folded[i]! |= bytes[start + i]! << (8 * plane);
  }
  for (let i = 0; i < count; i++) folded[i] = (folded[i]! >>> 1) ^ -(folded[i]! & 1);

  // Differences wrap around, and so do their sums.
  return Array.from({ length: columns }, (_, index) => {
    const column = folded.subarray(index * rows, (index + 1) * rows);
    for (let pass = 0; pass < order; pass++) {
      let sum = 0;
      for (let i = 0; i < rows; i++) column[i] = sum = (sum + column[i]!) | 0;
    }
    return column;
  });
}

/** What base64 text holds, inflated (zlib). */
export async function inflate(base64: string): Promise<Uint8Array> {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return unpacked(bytes);
}

/** Inflated bytes (zlib). */
export async function unpacked(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Response(bytes).body!.pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * Blobs of a stream, each after its length as four bytes, the lowest first; the last may be torn,
 * and is left out.
 */
export async function* blobs(
  stream: ReadableStream<Uint8Array>,
): AsyncGenerator<Uint8Array<ArrayBuffer>> {
  const reader = stream.getReader();
  let rest = new Uint8Array(0);
  for (;;) {
    const { done, value } = await reader.read().catch(() => ({ done: true, value: undefined }));
    if (done || value === undefined) return;
    const joined = new Uint8Array(rest.length + value.length);
    joined.set(rest);
    joined.set(value, rest.length);
    rest = joined;
    while (rest.length >= 4) {
      const length = new DataView(rest.buffer, rest.byteOffset).getUint32(0, true);
      if (rest.length < 4 + length) break;
      yield rest.slice(4, 4 + length);
      rest = rest.slice(4 + length);
    }
  }
}
