// A recording that the page around this one posts, as the widget of a notebook does:
// `python/frangible/live_widget.js`.

/** What stands in the page in place of a recording. */
export const POSTED = "posted";

type Told = { chunk: Uint8Array<ArrayBuffer> } | { pick: number | null };

export class Post {
  /** Called with the id of a body that is to be picked, or `null`. */
  onPick: (id: number | null) => void = () => {};
  private readonly chunks: Uint8Array<ArrayBuffer>[] = [];
  private wake: () => void = () => {};

  constructor() {
    addEventListener("message", ({ source, data }: MessageEvent<Told>) => {
      if (source !== parent) return;
      if ("chunk" in data) {
        this.chunks.push(data.chunk);
        this.wake();
      } else this.onPick(data.pick);
    });
    parent.postMessage("ready", "*");
  }

  /** Chunks as they come, for ever. */
  async *blobs(): AsyncGenerator<Uint8Array<ArrayBuffer>> {
    for (;;) {
      const next = this.chunks.shift();
      if (next !== undefined) yield next;
      else await new Promise<void>((resolve) => (this.wake = resolve));
    }
  }

  /** A reader picked a body, or `null`. */
  tellPick(id: number | null): void {
    parent.postMessage({ picked: id }, "*");
  }
}
