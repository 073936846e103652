// The playground: a world in the page, what somebody does to it, and what comes of that.
import { DataArrayTexture } from "three";
import { element, input, select } from "../element";
import { Player } from "../player";
import { counted } from "../units";
import { AHEAD, MOST_AHEAD, WorldBench } from "./bench";
import { LiveFootage } from "./live";
import { fillMenus } from "./menus";
import { hush, say } from "./message";
import type { Order, Story, Told } from "./protocol";
import { type Choice, type Dropped, type MaterialName, SHOTS, sceneOf } from "./recipe";
import { download, film, filmKind, piecesAsGltf } from "./save";
import { LONGEST, MOST_FRAMES, decode, encode } from "./share";
import { ball } from "./simulator";
import { TOOLS, type Tool, Tools } from "./tools";

/** What a tool does, for who has not used it. */
const HINTS: Record<Tool, string> = {
  throw: "Press to throw a ball, drag to turn the view.",
  drag: "Drag a piece; beside all pieces, turn the view.",
  slice: "Draw a line over what is to be cut.",
  burst: "Press on what is to break by its pattern; its pieces can be sliced.",
};
/** A film ends with a still picture, which also lets the encoder come to an end [ms]. */
const HELD = 700;
/** A first visit sees a ball on its way to the wall. */
const FIRST_BALL = { radius: 0.18, from: [0.3, 0.9, 4.2], velocity: [-1, 1.2, -18] };
/**
 * The first picture of a page takes half a second and more: meanwhile so much is simulated that the
 * second may show the ball among the pieces; a world that is slow is not waited for longer than
 * that [ms].
 */
const HEAD_START = { frames: 24, patience: 400 };

class Playground {
  footage: LiveFootage | null = null;
  player: Player | null = null;
  private fps = 60;
  private story: Story = { scene: "", actions: [] };
  private busy = 0;
  private dropped: Dropped | null = null;
  /** The story of a link, until something else is chosen. */
  private opened: Story | null = null;
  /** Number of balls. */
  throws = 0;
  /** Whether the next frame is shown as soon as it is made. */
  private stepping = false;
  /** The frame that is shown once all of a link is simulated. */
  private opening: number | null = null;
  private durations: number[] = [];
  /** Times of the pictures of the last second [ms]. */
  private pictures: number[] = [];
  /** While a film is made nothing is simulated. */
  private filming = false;
  private readonly tools: Tools;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly worker: Worker,
  ) {
    this.worker.addEventListener("message", ({ data }: MessageEvent<Told>) => this.hear(data));
    this.worker.addEventListener("error", () =>
      say("The engine stopped: reset, or load the page again."),
    );
    this.tools = new Tools(
      canvas,
      element("line") as unknown as SVGLineElement,
      new WorldBench(canvas, this),
    );
    fillMenus();
    // A small window is for the world.
    const recipe = element("recipe") as HTMLDetailsElement;
    recipe.addEventListener("toggle", () => document.body.classList.toggle("chooses", recipe.open));
    recipe.open = innerWidth > 640 && innerHeight > 480;
    this.listen();
  }

  /** Begin with a story, and stop at a frame of it. */
  open(story: Story, frames: number): void {
    this.opened = story;
    this.opening = frames;
    this.throws = story.actions.length;
    this.order({ kind: "build", story, frames });
  }

  /** Build what is chosen, and throw the first ball; a shot has its own. */
  reset(): void {
    this.tools.drop();
    if (this.opened !== null) {
      const { scene, actions } = this.opened;
      const story = { scene, actions: actions.filter((action) => action.frame === 0) };
      this.throws = story.actions.length;
      return this.order({ kind: "build", story, frames: 0 });
    }
    const name = select("shape").value;
    for (const id of ["material", "pattern", "pieces", "strength"])
      (element(id) as HTMLInputElement).disabled = name in SHOTS;
    this.throws = 0;
    if (name in SHOTS) return this.order({ kind: "shot", name });
    const scene = sceneOf(this.choice());
    this.throws = 1;
    const { radius, from, velocity } = FIRST_BALL;
    const story = { scene, actions: [{ frame: 0, add: ball(radius, from, velocity, 1) }] };
    this.order({ kind: "build", story, frames: 0 });
    if (this.player === null) this.order({ kind: "step", ...HEAD_START });
  }

  /** Build what the menu says, no longer what a link told. */
  private choose(): void {
    this.opened = null;
    this.reset();
  }

  order(order: Order): void {
    this.busy++;
    this.worker.postMessage(order);
  }

  private hear(told: Told): void {
    switch (told.kind) {
      case "fault":
        // What breaks while it is held slips out of the hand.
        if (this.tools.dragged !== null) return this.tools.drop();
        return say(told.sentence, 6000);
      case "built":
        hush();
        this.footage = null;
        this.durations = [];
        this.fps = told.framesPerSecond;
        return;
      case "frame":
        return this.take(told);
      case "undone":
        this.story = told.story;
        this.tools.drop();
        this.footage?.cut(told.frame);
        this.player?.takeIn();
        this.player?.clock.seek(told.frame - 1);
        if (this.player !== null) this.player.clock.playing = true;
        return;
      case "done":
        this.busy--;
        this.story = told.story;
        if (this.opening !== null) this.player?.clock.seek(this.opening);
        this.opening = null;
        this.tellDeeds();
    }
  }

  /** For tests, and for who looks closely. */
  private tellDeeds(): void {
    const { actions } = this.story;
    const count = (name: string): string =>
      String(actions.filter((action) => name in action).length);
    Object.assign(document.documentElement.dataset, {
      busy: String(this.busy),
      actions: String(actions.length),
      cuts: count("cut"),
      drags: count("hold"),
      bursts: count("burst"),
    });
  }

  private take({ state }: Told & { kind: "frame" }): void {
    this.durations = [...this.durations.slice(-59), state.duration];
    if (this.footage !== null) {
      if (this.footage.append(state)) this.player?.takeIn();
      // Without a picture, too.
      input("timeline").max = String(this.footage.frames);
      if (this.stepping) this.player?.clock.step(1);
      this.stepping = false;
      return;
    }
    this.footage = new LiveFootage("", this.fps, state);
    if (this.player === null) this.begin(this.footage);
    else this.player.show(this.footage);
    this.player!.clock.playing = this.opening === null;
  }

  private begin(footage: LiveFootage): void {
    const images = new DataArrayTexture(new Uint8Array(4).fill(255), 1, 1, 1);
    images.needsUpdate = true;
    this.player = new Player(footage, images, this.canvas, () =>
      say("The graphics driver gave up on this page: load it again."),
    );
    this.player.onDraw = () => this.show();
    this.player.onUpdate = () => this.goOn();
    this.player.start();
  }

  /** Simulate ahead of what is shown. */
  private goOn(): void {
    const { player, footage } = this;
    if (
      player === null ||
      footage === null ||
      this.busy > 0 ||
      this.filming ||
      !player.clock.playing
    )
      return;
    const framesAPicture = (this.fps * player.clock.speed) / Math.max(this.pictures.length, 1);
    const ahead = Math.min(Math.max(Math.ceil(framesAPicture), AHEAD), MOST_AHEAD);
    const missing = Math.ceil(player.clock.time) + ahead - footage.frames;
    if (missing <= 0) return;
    this.tools.order();
    this.order({ kind: "step", frames: Math.min(missing, ahead) });
  }

  private show(): void {
    const { player, footage } = this;
    if (player === null || footage === null) return;
    const { clock } = player;
    const state = footage.state(clock.frame);
    const median = [...this.durations].sort((a, b) => a - b)[this.durations.length >> 1] ?? 0;
    const now = performance.now();
    this.pictures = [...this.pictures.filter((time) => time > now - 1000), now];
    this.tools.show();
    element("frame").textContent = `frame ${clock.frame}`;
    element("bodies").textContent = counted(state.ids.length, "body", "bodies");
    element("step").textContent = `${median.toFixed(1)} ms a step`;
    element("rate").textContent = clock.playing
      ? `${counted(this.pictures.length, "picture")} a second`
      : "";
    element("energy").textContent = `${(state.energy / 1000).toFixed(2)} kJ`;
    input("timeline").max = String(footage.frames);
    input("timeline").value = String(clock.time);
    element("play").textContent = clock.playing ? "Pause" : "Play";
    const data = document.documentElement.dataset;
    [data["level"], data["calls"]] = [String(player.drawn.level), String(player.drawn.calls)];
    data["eye"] = player.camera.position.toArray().map((part) => part.toFixed(2)).join();
    [data["frame"], data["bodies"], data["hash"], data["frames"]] = [
      String(clock.frame),
      String(state.ids.length),
      state.hash,
      String(footage.frames),
    ];
  }

  private choice(): Choice {
    const shape = select("shape").value;
    return {
      shape: shape === "dropped" && this.dropped !== null ? this.dropped : shape,
      material: select("material").value as MaterialName,
      pattern: select("pattern").value,
      pieces: Number(input("pieces").value),
      strength: 10 ** Number(input("strength").value),
    };
  }

  private listen(): void {
    for (const id of ["shape", "material", "pattern", "pieces", "strength"])
      element(id).addEventListener("change", () => this.choose());
    element("reset").addEventListener("click", () => this.reset());
    element("undo").addEventListener("click", () => this.order({ kind: "undo" }));
    element("play").addEventListener("click", () => this.player?.clock.toggle());
    element("forth").addEventListener("click", () => this.stepOnce());
    element("use").addEventListener("click", () => this.tools.use());
    for (const tool of TOOLS) element(tool).addEventListener("click", () => this.takeUp(tool));
    element("gltf").addEventListener("click", () => void this.saveGltf());
    element("film").hidden = filmKind(this.canvas) === null;
    element("film").addEventListener("click", () => void this.saveFilm());
    element("share").addEventListener("click", () => void this.share());
    select("speed").addEventListener(
      "change",
      () => this.player && (this.player.clock.speed = Number(select("speed").value)),
    );
    input("explode").addEventListener(
      "input",
      () => this.player && (this.player.explode = Number(input("explode").value)),
    );
    input("timeline").addEventListener("input", () =>
      this.player?.clock.seek(Number(input("timeline").value)),
    );
    input("file").addEventListener("change", () => void this.drop(input("file").files));
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      void this.drop(event.dataTransfer?.files ?? null);
    });
    addEventListener("keydown", (event) => this.key(event));
  }

  private takeUp(tool: Tool): void {
    this.tools.tool = tool;
    for (const each of TOOLS) element(each).setAttribute("aria-pressed", String(each === tool));
    element("hint").textContent = HINTS[tool];
    // A finger that cuts does not turn the view, and a hand is not needed at the middle.
    (element("use") as HTMLButtonElement).disabled = tool === "drag";
  }

  private key(event: KeyboardEvent): void {
    const { target } = event;
    if (target instanceof HTMLElement && target.matches("select, input")) return;
    // Space and Enter press the button that has the focus.
    if (target instanceof HTMLButtonElement && (event.key === " " || event.key === "Enter")) return;
    const keys: Record<string, () => void> = {
      " ": () => this.player?.clock.toggle(),
      Enter: () => this.tools.use(),
      ...Object.fromEntries(
        TOOLS.map((tool, number) => [String(number + 1), () => this.takeUp(tool)]),
      ),
      ArrowRight: () => this.stepOnce(),
      u: () => this.order({ kind: "undo" }),
      r: () => this.reset(),
    };
    const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (action === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  }

  private stepOnce(): void {
    const { player, footage } = this;
    if (player === null || footage === null) return;
    if (player.clock.frame < footage.frames) return player.clock.step(1);
    player.clock.playing = false;
    this.stepping = true;
    if (this.busy === 0) this.order({ kind: "step", frames: 1 });
  }

  private async saveGltf(): Promise<void> {
    const { player, footage } = this;
    if (player === null || footage === null) return;
    download(`frame ${player.clock.frame}.glb`, await piecesAsGltf(footage, player.clock.frame));
  }

  /** Plays all frames while they are filmed. */
  private async saveFilm(): Promise<void> {
    const { player, footage } = this;
    const kind = filmKind(this.canvas);
    if (player === null || footage === null || kind === null || this.filming) return;
    this.filming = true;
    say("The film is being made, in real time …");
    const content = await film(this.canvas, kind, async () => {
      player.clock.seek(0);
      player.clock.playing = true;
      while (player.clock.playing && player.clock.time < footage.frames && this.footage === footage)
        await new Promise(requestAnimationFrame);
      await new Promise((done) => setTimeout(done, HELD));
    });
    this.filming = false;
    player.clock.playing = false;
    say("");
    download(`frangible.${kind.includes("mp4") ? "mp4" : "webm"}`, content);
  }

  private async share(): Promise<void> {
    const frames = this.footage?.frames ?? 0;
    if (frames > MOST_FRAMES)
      return say(
        `This world is too old for a link: it must have at most ${MOST_FRAMES} frames.`,
        6000,
      );
    const text = await encode(this.story);
    if (text.length > LONGEST)
      return say("This world is too long for a link: a dropped mesh must have fewer triangles.");
    const link = `${location.href.split("#")[0]}#frames=${frames}&story=${text}`;
    history.replaceState(null, "", link);
    await navigator.clipboard?.writeText(link).catch(() => {});
    document.documentElement.dataset["shared"] = String(frames);
    say("The link to this world is in the address, and on the clipboard.", 4000);
  }

  private async drop(files: FileList | null): Promise<void> {
    const file = files?.[0];
    if (file === undefined) return;
    try {
      // Few visitors need what reads meshes.
      const { readMesh } = await import("./drop");
      this.dropped = await readMesh(file.name, await file.arrayBuffer());
    } catch (error) {
      return say(`${file.name}: ${error instanceof Error ? error.message : String(error)}`, 8000);
    }
    say(`${file.name} is being built …`);
    const menu = select("shape");
    if (menu.querySelector('[value="dropped"]') === null) menu.append(new Option("", "dropped"));
    menu.querySelector('[value="dropped"]')!.textContent = file.name;
    menu.value = "dropped";
    this.choose();
  }
}

/** Begin with what the address asks for. */
export async function open(worker: Worker): Promise<void> {
  const playground = new Playground(element("view") as HTMLCanvasElement, worker);
  // Another link in the address is another world.
  addEventListener("hashchange", () => location.reload());
  const asked = new URLSearchParams(location.hash.slice(1));
  const story = asked.get("story");
  if (story === null) return playground.reset();
  const told = await decode(story).catch(() => null);
  if (told === null) {
    say("The link is damaged: here is a wall instead.", 4000);
    return playground.reset();
  }
  playground.open(told, Math.min(Math.max(Number(asked.get("frames")) || 0, 0), MOST_FRAMES));
}
