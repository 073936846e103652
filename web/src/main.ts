// The page: reads the recording inside it, or the one that its server streams, and plays it.
import { QUANTITIES, type Quantity } from "./colouring";
import { loadImages } from "./images";
import { element } from "./element";
import { Panel } from "./panel";
import { Player } from "./player";
import { POSTED, Post } from "./posted";
import { Reel } from "./reel";
import { blobs, inflate, unpacked } from "./streams";

/** Where the server of the page streams chunks. */
const CHUNKS = "chunks";
const LOST = "The graphics driver gave up on this page: load it again.";

/** Tell in a sentence what is wrong. */
function say(sentence: string): void {
  element("message").textContent = sentence;
  element("message").hidden = sentence === "";
}

/** What keeps this browser from playing; empty if nothing does. */
function missing(): string {
  if (typeof DecompressionStream === "undefined")
    return "This browser cannot unpack the recording: it is older than 2023.";
  const context = document.createElement("canvas").getContext("webgl2");
  if (context === null)
    return "This browser shows no 3D graphics: WebGL 2 is missing or switched off.";
  if (context.getExtension("EXT_color_buffer_float") === null)
    return (
      "The graphics driver of this machine cannot draw into floating-point textures, " +
      "which the pictures need."
    );
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return "";
}

/** What the address asks for. */
const asked = new URLSearchParams(location.hash.slice(1));

/**
 * Do what the address asks for as soon as it can be done: of a run that goes on, some of it only
 * later.
 */
function obey(player: Player, panel: Panel): void {
  const { clock, footage } = player;
  const number = (name: string): number => Number(asked.get(name)) || 0;
  if (asked.has("frame")) {
    clock.seek(number("frame"));
    if (footage.frames >= number("frame") || !footage.grows) asked.delete("frame");
  }
  if (asked.has("explode") && panel.changeExplode(number("explode"))) asked.delete("explode");
  if (asked.has("pick") && panel.pick(number("pick"))) asked.delete("pick");
}

/** Play what is there, and what the address asks for. */
async function play(reel: Reel): Promise<[Player, Panel]> {
  const canvas = element("view") as HTMLCanvasElement;
  const player = new Player(reel, await loadImages(reel.images), canvas, () => say(LOST));
  const panel = new Panel(player, reel.books, canvas);
  const state = document.documentElement.dataset;
  player.onDraw = (settled) => {
    panel.show();
    state["frame"] = String(player.clock.frame);
    state["calls"] = String(player.drawn.calls);
    state["state"] = player.clock.playing ? "playing" : settled ? "settled" : "paused";
  };
  say("");
  const colour = asked.get("colour") as Quantity;
  if (QUANTITIES.includes(colour)) panel.colourBy(colour);
  if (asked.has("quality")) player.spend(Number(asked.get("quality")));
  player.clock.playing =
    !asked.has("frame") && !matchMedia("(prefers-reduced-motion: reduce)").matches;
  obey(player, panel);
  player.start();
  return [player, panel];
}

/** What the server of the page streams. */
async function streamed(): Promise<AsyncIterable<Uint8Array<ArrayBuffer>>> {
  const response = await fetch(CHUNKS);
  if (!response.ok || response.body === null)
    throw new Error(`its server answers ${response.status}`);
  return blobs(response.body);
}

/** Pick what the page around this one says, and tell it what is picked here. */
function sharePicks(post: Post, reel: Reel, panel: Panel): void {
  const rowOf = (id: number | null): number => reel.bodies.findIndex((body) => body.id === id);
  post.onPick = (id) => panel.pick(rowOf(id));
  panel.onPick = (row) => post.tellPick(reel.bodies[row]?.id ?? null);
}

/** Play chunks while they come. */
async function follow(chunks: AsyncIterable<Uint8Array<ArrayBuffer>>, post?: Post): Promise<void> {
  const reel = new Reel();
  let shown: [Player, Panel] | null = null;
  for await (const blob of chunks) {
    const images = reel.images.length;
    const hasNew = reel.append(await unpacked(blob));
    if (shown === null) {
      shown = await play(reel);
      if (post !== undefined) sharePicks(post, reel, shown[1]);
      continue;
    }
    const [player, panel] = shown;
    if (reel.images.length > images) player.restage(await loadImages(reel.images));
    else if (hasNew) player.takeIn();
    panel.takeIn();
    obey(player, panel);
    document.documentElement.dataset["frames"] = String(reel.frames);
  }
  // The run was stopped before its end.
  if (reel.grows && shown !== null) {
    reel.grows = false;
    shown[1].takeIn();
  }
}

async function main(): Promise<void> {
  const fault = missing();
  if (fault !== "") return say(fault);
  say("Unpacking the recording …");
  const data = element("recording").textContent?.trim() ?? "";
  element("recording").remove();
  if (data === "") return follow(await streamed());
  if (data === POSTED) {
    const post = new Post();
    return follow(post.blobs(), post);
  }
  const reel = new Reel();
  reel.append(await inflate(data));
  await play(reel);
}

main().catch((error: unknown) => {
  say(`The recording cannot be played: ${error instanceof Error ? error.message : String(error)}.`);
  console.error(error);
});
