// The page: reads the recording inside it and plays it.
import { loadImages } from "./images";
import { Panel, element } from "./panel";
import { Player } from "./player";
import { readRecording } from "./recording";
import { inflate } from "./streams";

/** Tell in a sentence what is wrong. */
function say(sentence: string): void {
  element("message").textContent = sentence;
  element("message").hidden = sentence === "";
}

/** What keeps this browser from playing; empty if nothing does. */
function missing(): string {
  if (typeof DecompressionStream === "undefined") return "This browser cannot unpack the recording: it is older than 2023.";
  const context = document.createElement("canvas").getContext("webgl2");
  if (context === null) return "This browser shows no 3D graphics: WebGL 2 is missing or switched off.";
  if (context.getExtension("EXT_color_buffer_float") === null)
    return "The graphics driver of this machine cannot draw into floating-point textures, which the pictures need.";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return "";
}

async function main(): Promise<void> {
  const fault = missing();
  if (fault !== "") return say(fault);
  say("Unpacking the recording …");
  const recording = readRecording(await inflate(element("recording").textContent ?? ""));
  element("recording").remove();
  const canvas = element("view") as HTMLCanvasElement;
  const images = await loadImages(recording.images);
  const player = new Player(recording, images, canvas, () => say("The graphics driver gave up on this page: load it again."));
  const panel = new Panel(player);
  const state = document.documentElement.dataset;
  player.onDraw = (settled) => {
    panel.show();
    state["frame"] = String(player.clock.frame);
    state["state"] = player.clock.playing ? "playing" : settled ? "settled" : "paused";
  };
  say("");
  const asked = new URLSearchParams(location.hash.slice(1));
  panel.changeExplode(Number(asked.get("explode")) || 0);
  if (asked.has("frame")) player.clock.seek(Number(asked.get("frame")) || 0);
  else player.clock.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  player.start();
}

main().catch((error: unknown) => {
  say(`The recording cannot be played: ${error instanceof Error ? error.message : String(error)}.`);
  console.error(error);
});
