// Caption, time line, buttons and keys.
import type { Player } from "./player";
import { breaks, countAlive } from "./recording";
import { drawMarks } from "./marks";

/** Paths of the buttons' pictures, on a square of 24. */
const ICONS: Record<string, string> = {
  play: "M7 4v16l13-8z",
  pause: "M6 4h4v16H6zM14 4h4v16h-4z",
  first: "M5 4h3v16H5zM20 4v16L9 12z",
  back: "M16 4v16L5 12zM17 4h3v16h-3z",
  forth: "M8 4v16l11-8zM4 4h3v16H4z",
  break: "M13 2 5 13h5l-2 9 9-12h-5z",
  reset: "M12 3 2 11h3v9h5v-6h4v6h5v-9h3z",
  full: "M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z",
  help: "M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20zm-1 14h2v2h-2zm4.1-5.6L14 11.500c-.7.7-1 1.300-1 2.500h-2v-.5c0-1.100.4-2.100 1.100-2.800l1.300-1.300A2 2 0 1 0 10 8H8a4 4 0 1 1 7.100 2.400z",
};

export class Panel {
  private readonly speeds: number[];
  private readonly breaks;

  constructor(private readonly player: Player) {
    const { footage: recording, clock } = player;
    this.breaks = breaks(recording);
    element("shot").textContent = recording.shot || "Recording";
    const timeline = input("timeline");
    timeline.max = String(recording.frames);
    timeline.addEventListener("input", () => clock.seek(Number(timeline.value)));
    const explode = input("explode");
    explode.addEventListener("input", () => (player.explode = Number(explode.value)));
    explode.disabled = recording.bodies.every((body) => body.pull.every((part) => part === 0));
    if (explode.disabled) explode.title = "Nothing has broken";
    const speed = element("speed") as HTMLSelectElement;
    this.speeds = Array.from(speed.options, (option) => Number(option.value));
    speed.addEventListener("change", () => (clock.speed = Number(speed.value)));

    for (const name of Object.keys(ICONS)) if (name !== "pause") icon(name, name);
    this.on("play", () => clock.toggle());
    this.on("first", () => clock.seek(0));
    this.on("back", () => clock.step(-1));
    this.on("forth", () => clock.step(1));
    this.on("break", () => this.nextBreak());
    this.on("reset", () => player.resetView());
    this.on("full", toggleFullScreen);
    this.on("help", toggleHelp);
    (element("break") as HTMLButtonElement).disabled = this.breaks.length === 0;
    addEventListener("keydown", (event) => this.key(event));
    const marks = element("marks") as HTMLCanvasElement;
    new ResizeObserver(() => drawMarks(marks, this.breaks, recording.frames)).observe(marks);
    for (const id of ["caption", "controls"]) element(id).hidden = false;
    // Help comes over the picture; all else leaves it free.
    const [controls, keys] = [element("controls"), element("keys")];
    const free = (): void => {
      if (keys.hidden) player.keepFree(innerHeight - controls.getBoundingClientRect().top);
    };
    new ResizeObserver(free).observe(controls);
    addEventListener("resize", free);
    free();
  }

  /** Say what is drawn. */
  show(): void {
    const { clock, footage: recording } = this.player;
    const alive = countAlive(recording, clock.frame);
    const settings = [
      ["frame", `frame ${clock.frame} of ${recording.frames}`],
      ["time", `${(clock.time / recording.fps).toFixed(2)} s`],
      ["bodies", alive === 1 ? "1 body" : `${alive} bodies`],
    ] as const;
    for (const [id, text] of settings) if (element(id).textContent !== text) element(id).textContent = text;
    input("timeline").value = String(clock.time);
    input("timeline").setAttribute("aria-valuetext", `frame ${clock.frame}`);
    if (element("play").dataset["icon"] !== (clock.playing ? "pause" : "play")) {
      icon("play", clock.playing ? "pause" : "play");
      element("play").setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    }
  }

  private on(id: string, action: () => void): void {
    element(id).addEventListener("click", action);
  }

  private nextBreak(): void {
    const { clock } = this.player;
    const next = this.breaks.find(({ frame }) => frame > clock.time) ?? this.breaks[0];
    if (next !== undefined) clock.seek(next.frame);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // A control that has the focus keeps the keys that it knows.
    const focused = event.target instanceof HTMLElement ? event.target : document.body;
    if (focused.matches("select") || (focused.matches("input") && /^(Arrow|Home|End)/.test(event.key))) return;
    if (focused.matches("button") && event.key === " ") return;
    const action = this.keys()[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (action === undefined) return;
    event.preventDefault();
    action(event.shiftKey);
  }

  private keys(): Record<string, (shift: boolean) => void> {
    const { clock, footage: recording } = this.player;
    return {
      " ": () => clock.toggle(),
      ArrowLeft: () => clock.step(-1),
      ArrowRight: () => clock.step(1),
      ArrowUp: () => this.changeSpeed(1),
      ArrowDown: () => this.changeSpeed(-1),
      Home: () => clock.seek(0),
      End: () => clock.seek(recording.frames),
      b: () => this.nextBreak(),
      e: (shift) => this.changeExplode(shift ? -0.1 : 0.1),
      r: () => this.player.resetView(),
      f: toggleFullScreen,
      "?": toggleHelp,
      h: toggleHelp,
    };
  }

  private changeSpeed(by: number): void {
    const speed = element("speed") as HTMLSelectElement;
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), this.speeds.length - 1);
    this.player.clock.speed = this.speeds[speed.selectedIndex]!;
  }

  changeExplode(by: number): void {
    const explode = input("explode");
    if (explode.disabled) return;
    explode.value = String(Number(explode.value) + by);
    this.player.explode = Number(explode.value);
  }
}

export function element(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found;
}

function input(id: string): HTMLInputElement {
  return element(id) as HTMLInputElement;
}

function icon(id: string, name: string): void {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", ICONS[name]!);
  svg.append(path);
  element(id).replaceChildren(svg);
  element(id).dataset["icon"] = name;
}

function toggleFullScreen(): void {
  if (document.fullscreenElement) void document.exitFullscreen();
  else void document.documentElement.requestFullscreen?.();
}

function toggleHelp(): void {
  const keys = element("keys");
  keys.hidden = !keys.hidden;
  element("help").setAttribute("aria-expanded", String(!keys.hidden));
}
