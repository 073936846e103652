// Caption, time line, buttons and keys.
import { Announcer } from "./announcer";
import type { Books } from "./books";
import { Colouring, QUANTITIES, type Quantity } from "./colouring";
import { element, input, select } from "./element";
import { EnergyGraph } from "./energy_graph";
import { icon } from "./icons";
import { type Key, list, listen } from "./keys";
import { Legend } from "./legend";
import { drawMarks } from "./marks";
import { Motion } from "./motion";
import { Picking } from "./picking";
import type { Player } from "./player";
import { type Break, breaks, countAlive } from "./recording";
import { counted } from "./units";

/**
 * A window that is lower has no room for a graph at first; a narrow one has more rows of buttons
 * [CSS px].
 */
const ROOM_FOR_GRAPH = "(min-height: 560px) and (min-width: 561px), (min-height: 720px)";

export class Panel {
  private readonly speeds: number[];
  private breaks: Break[] = [];
  private readonly colouring: Colouring;
  private readonly picking: Picking;
  private readonly graph: EnergyGraph;
  private readonly legend = new Legend(element("legend"));
  private readonly announcer = new Announcer(element("spoken"));
  private wantsGraph = matchMedia(ROOM_FOR_GRAPH).matches;

  constructor(
    private readonly player: Player,
    private readonly books: Books,
    canvas: HTMLCanvasElement,
  ) {
    const { footage, clock } = player;
    const motion = new Motion(footage, () => books.gravity);
    this.colouring = new Colouring(footage, motion);
    player.painter = this.colouring;
    this.picking = new Picking(player, canvas, motion, books.strikes);
    this.graph = new EnergyGraph(
      books,
      element("graph") as HTMLCanvasElement,
      element("graph-legend"),
      element("graph-words"),
    );
    element("shot").textContent = footage.shot || "Recording";
    const timeline = input("timeline");
    timeline.addEventListener("input", () => clock.seek(Number(timeline.value)));
    const explode = input("explode");
    explode.addEventListener("input", () => (player.explode = Number(explode.value)));
    const speed = select("speed");
    this.speeds = Array.from(speed.options, (option) => Number(option.value));
    speed.addEventListener("change", () => (clock.speed = Number(speed.value)));
    const colour = select("colour");
    colour.replaceChildren(...QUANTITIES.map((quantity) => new Option(NAMES[quantity], quantity)));
    colour.addEventListener("change", () => this.colourBy(colour.value as Quantity));
    this.listen();

    for (const id of ["caption", "controls"]) element(id).hidden = false;
    this.takeIn();
    // Help comes over the picture; all else leaves it free.
    const [controls, keys] = [element("controls"), element("keys")];
    const free = (): void => {
      if (keys.hidden) player.keepFree(innerHeight - controls.getBoundingClientRect().top);
    };
    new ResizeObserver(free).observe(controls);
    addEventListener("resize", free);
    free();
  }

  /** There are more frames, perhaps more breaks. */
  takeIn(): void {
    const { footage } = this.player;
    this.breaks = breaks(footage);
    input("timeline").max = String(footage.frames);
    const explode = input("explode");
    explode.disabled = footage.bodies.every((body) => body.pull.every((part) => part === 0));
    explode.title = explode.disabled ? "Nothing has broken" : "";
    (element("break") as HTMLButtonElement).disabled = this.breaks.length === 0;
    this.showGraph();
    element("live").hidden = !footage.grows;
    this.drawMarks();
    this.show();
  }

  /** Say what is drawn. */
  show(): void {
    const { clock, footage } = this.player;
    const alive = countAlive(footage, clock.frame);
    const settings = [
      ["frame", `frame ${clock.frame} of ${footage.frames}`],
      ["time", `${(clock.time / footage.fps).toFixed(2)} s`],
      ["bodies", counted(alive, "body", "bodies")],
    ] as const;
    for (const [id, text] of settings)
      if (element(id).textContent !== text) element(id).textContent = text;
    input("timeline").value = String(clock.time);
    input("timeline").setAttribute("aria-valuetext", `frame ${clock.frame}`);
    if (element("play").dataset["icon"] !== (clock.playing ? "pause" : "play")) {
      icon(element("play"), clock.playing ? "pause" : "play");
      element("play").setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    }
    this.picking.show();
    this.legend.show(this.colouring);
    this.graph.show(clock.time, footage.frames);
    this.tell();
  }

  colourBy(quantity: Quantity): void {
    this.colouring.quantity = quantity;
    select("colour").value = quantity;
  }

  /** Pull pieces apart by so much more; false if nothing has broken yet. */
  changeExplode(by: number): boolean {
    const explode = input("explode");
    if (explode.disabled) return false;
    explode.value = String(Number(explode.value) + by);
    this.player.explode = Number(explode.value);
    return true;
  }

  /** Pick a body by its row, or none with -1; false if there is no such body yet. */
  pick(row: number): boolean {
    if (!(row >= -1 && row < this.player.footage.bodies.length)) return false;
    if (row !== this.player.picked) this.picking.pick(row);
    return true;
  }

  /** Called with the row of each body that is picked, or -1. */
  set onPick(hear: (row: number) => void) {
    this.picking.onPick = hear;
  }

  private tell(): void {
    const { clock, footage } = this.player;
    const so = this.breaks.filter(({ frame }) => frame <= clock.frame);
    const known = this.books.strikes.filter(({ frame }) => frame <= clock.frame).length;
    const count = known || so.length;
    const doing = clock.playing ? "Playing" : "Paused";
    const seconds = (clock.time / footage.fps).toFixed(2);
    const bodies = counted(countAlive(footage, clock.frame), "body", "bodies");
    const parts = [
      `${doing} at frame ${clock.frame} of ${footage.frames}, ${seconds} seconds`,
      `${bodies}, ${counted(count, "break")} so far`,
    ];
    this.announcer.tell(`${parts.join("; ")}. ${this.picking.sentence}`.trim(), clock.playing);
  }

  private drawMarks(): void {
    drawMarks(element("marks") as HTMLCanvasElement, this.breaks, this.player.footage.frames);
  }

  private listen(): void {
    const { clock } = this.player;
    const actions: Record<string, () => void> = {
      play: () => clock.toggle(),
      first: () => clock.seek(0),
      back: () => clock.step(-1),
      forth: () => clock.step(1),
      break: () => this.nextBreak(1),
      loop: () => this.toggleLoop(),
      "graph-toggle": () => this.toggleGraph(),
      reset: () => this.player.resetView(),
      full: toggleFullScreen,
      help: toggleHelp,
    };
    for (const [id, action] of Object.entries(actions)) {
      icon(element(id), id);
      element(id).addEventListener("click", action);
    }
    for (const id of ["piece-before", "piece-after", "piece-focus", "piece-close"])
      icon(element(id), id);
    new ResizeObserver(() => this.drawMarks()).observe(element("marks"));
    new ResizeObserver(() => this.show()).observe(element("graph"));
    const keys = this.keys();
    listen(keys);
    list(keys, element("keys"));
  }

  private keys(): Key[] {
    const { clock, viewpoint } = this.player;
    const key = (keys: string, shown: string, says: string, does: Key["does"]): Key => ({
      keys: keys.split(" ").map((name) => name || " "), shown: shown.split(" "), says, does,
    });
    const arrows: Record<string, () => void> = {
      ArrowLeft: () => clock.step(-1),
      ArrowRight: () => clock.step(1),
      ArrowUp: () => this.changeSpeed(1),
      ArrowDown: () => this.changeSpeed(-1),
    };
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, 1],
      ArrowDown: [0, -1],
    };
    const arrow: Key["does"] = (shift, name) =>
      shift ? viewpoint.turn(...turns[name]!) : arrows[name]!();
    return [
      { keys: [" ", "k"], shown: ["space"], says: "play or pause", does: () => clock.toggle() },
      key("ArrowLeft ArrowRight", "← →", "one frame back, forth", arrow),
      key("ArrowUp ArrowDown", "↑ ↓", "faster, slower", arrow),
      key("Home End", "Home End", "first, last frame", (_, name) =>
        clock.seek(name === "Home" ? 0 : Infinity),
      ),
      key("b", "B Shift+B", "next break, the one before", (shift) =>
        this.nextBreak(shift ? -1 : 1),
      ),
      key("l", "L", "loop", () => this.toggleLoop()),
      key("p", "P Shift+P", "pick the next body, the one before", (shift) =>
        this.picking.next(shift ? -1 : 1),
      ),
      key("o", "O Shift+O", "pick what it broke off from, a piece of it", (shift) =>
        this.picking.family(shift),
      ),
      key("f", "F", "look at the picked body", (shift) =>
        shift ? toggleFullScreen() : this.player.focus(),
      ),
      key("Escape", "Esc", "pick nothing, close help", () => this.escape()),
      key("c", "C Shift+C", "next colours, those before", (shift) =>
        this.changeColour(shift ? -1 : 1),
      ),
      key("e", "E Shift+E", "pull pieces apart, together", (shift) =>
        this.changeExplode(shift ? -0.1 : 0.1),
      ),
      key("g", "G", "energy", () => this.toggleGraph()),
      { keys: [], shown: ["Shift", "← → ↑ ↓"], says: "turn the view", does: () => {} },
      key("+ = -", "+ −", "nearer, further away", (_, name) => viewpoint.zoom(name !== "-")),
      key("w a s d", "W A S D", "move the view", (_, name) => viewpoint.move(...MOVES[name]!)),
      key("r", "R", "first view", () => this.player.resetView()),
      { keys: [], shown: ["Shift+F"], says: "full screen", does: () => {} },
      key("? h", "?", "these keys", toggleHelp),
    ];
  }

  private escape(): void {
    if (!element("keys").hidden) toggleHelp();
    else this.picking.pick(-1);
  }

  private nextBreak(direction: number): void {
    const { clock } = this.player;
    const next =
      direction > 0
        ? (this.breaks.find(({ frame }) => frame > clock.time) ?? this.breaks[0])
        : (this.breaks.filter(({ frame }) => frame < clock.time).at(-1) ?? this.breaks.at(-1));
    if (next !== undefined) clock.seek(next.frame);
  }

  private toggleLoop(): void {
    this.player.clock.loop = !this.player.clock.loop;
    element("loop").setAttribute("aria-pressed", String(this.player.clock.loop));
  }

  private toggleGraph(): void {
    this.wantsGraph = !this.wantsGraph;
    this.showGraph();
    this.show();
  }

  private showGraph(): void {
    element("energy").hidden = this.graph.isEmpty || !this.wantsGraph;
    (element("graph-toggle") as HTMLButtonElement).disabled = this.graph.isEmpty;
    element("graph-toggle").setAttribute("aria-expanded", String(!element("energy").hidden));
  }

  private changeSpeed(by: number): void {
    const speed = select("speed");
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), this.speeds.length - 1);
    this.player.clock.speed = this.speeds[speed.selectedIndex]!;
  }

  private changeColour(by: number): void {
    const index = QUANTITIES.indexOf(this.colouring.quantity) + by + QUANTITIES.length;
    this.colourBy(QUANTITIES[index % QUANTITIES.length]!);
  }
}

/** Colours as people choose them. */
const NAMES: Record<Quantity, string> = {
  material: "material",
  piece: "piece",
  generation: "generation",
  speed: "speed",
  age: "age",
  force: "contact force",
};

/** To the right and up. */
const MOVES: Record<string, [number, number]> = { w: [0, 1], a: [-1, 0], s: [0, -1], d: [1, 0] };

function toggleFullScreen(): void {
  if (document.fullscreenElement) void document.exitFullscreen();
  else void document.documentElement.requestFullscreen?.();
}

function toggleHelp(): void {
  const keys = element("keys");
  keys.hidden = !keys.hidden;
  element("help").setAttribute("aria-expanded", String(!keys.hidden));
  // Where the window is narrow, what else there is makes room.
  document.body.classList.toggle("helps", !keys.hidden);
}
