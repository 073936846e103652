// Plays a recording on a canvas: time, camera, and when to draw.
import {
  type DataArrayTexture, MOUSE, PerspectiveCamera, Raycaster, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Clock } from "./clock";
import { numbers } from "./geometry";
import { Picker } from "./picker";
import { TEXELS } from "./poses";
import type { Footage } from "./recording";
import { type Quality, Stage } from "./stage";
import { Viewpoint } from "./viewpoint";

/**
 * Width over height that the first view was made for: a narrower window sees as far to the sides.
 */
const ASPECT = 16 / 9;
/**
 * Pictures of the same that are averaged while nothing moves, and the time after which they are
 * enough [ms].
 */
const PICTURES = 32;
const PATIENCE = 6000;
/** From best to cheapest. The first pictures are the cheapest, so that they come soon. */
const LEVELS: readonly (Quality & { pixelRatio: number })[] = [
  { pixelRatio: 2, taps: 24, ambient: true, samples: 4, shadow: 2048, isCoarse: false },
  { pixelRatio: 1, taps: 12, ambient: true, samples: 4, shadow: 2048, isCoarse: false },
  { pixelRatio: 0.75, taps: 6, ambient: false, samples: 4, shadow: 2048, isCoarse: false },
  { pixelRatio: 0.5, taps: 4, ambient: false, samples: 0, shadow: 1024, isCoarse: true },
  { pixelRatio: 0.5, taps: 1, ambient: false, samples: 0, shadow: 512, isCoarse: true },
];
/**
 * A step down is taken when a picture takes longer, and a step up when it takes no longer [ms]: a
 * screen shows thirty a second at least. Between the two nothing changes.
 */
const TOO_LONG = 45;
const SHORT = 36;
/**
 * Pictures whose median counts: machines that are quick have the best after a third of a second.
 */
const FOR_LESS = 12;
const FOR_MORE = 5;
const BEST = 0;
const CHEAPEST = LEVELS.length - 1;
/**
 * What rests that long is drawn at this level or a better one, and what plays and waits for its
 * next frame so long: a picture at this level keeps a slow machine from making that frame [ms].
 */
const REST = 300;
const WAITS = 2000;
const SHARP = 1;
/**
 * Way of the eye, relative to its distance, within which it stands still: rounding moves it, and
 * pictures never settled.
 */
const SAME_VIEW = 1e-7;

/** No more is drawn here: the driver took the context away. */
export type OnLost = () => void;

/**
 * Writes colours of bodies at a time, with a body picked or -1; true if they changed. See
 * `Colouring`.
 */
export interface Painter {
  paint(looks: Float32Array, time: number, picked: number): boolean;
}

export class Player {
  clock!: Clock;
  footage!: Footage;
  /** By how much pieces are pulled apart. */
  explode = 0;
  /** The row of the body that is picked; -1 for none. */
  picked = -1;
  /** Who colours the bodies, if not their materials. */
  painter: Painter | null = null;
  /** Called after every picture. */
  onDraw: (settled: boolean) => void = () => {};
  /** Called before every picture that may be drawn. */
  onUpdate: () => void = () => {};
  private readonly renderer: WebGLRenderer;
  readonly camera: PerspectiveCamera;
  private readonly orbit: OrbitControls;
  readonly viewpoint: Viewpoint;
  private picker!: Picker;
  private stage: Stage | null = null;
  private level = CHEAPEST;
  /** What is better has been too slow. */
  private best = BEST;
  private durations: number[] = [];
  private isResting = false;
  private picture = 0;
  private still = 0;
  private last = performance.now();
  /** Height of what covers the lower edge [CSS px]. */
  private covered = 0;
  private state = "";
  private readonly eye = new Vector3();
  private readonly target = new Vector3();
  private turns = 0;

  constructor(
    footage: Footage,
    private images: DataArrayTexture,
    private readonly canvas: HTMLCanvasElement,
    onLost: OnLost,
  ) {
    this.renderer = new WebGLRenderer({
      canvas,
      antialias: false,
      alpha: false,
      powerPreference: "high-performance",
    });
    this.renderer.autoClear = false;
    this.renderer.info.autoReset = false;
    canvas.addEventListener("webglcontextlost", onLost);

    this.camera = new PerspectiveCamera(footage.camera.fieldOfView);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.enableDamping = true;
    this.orbit.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.PAN };
    this.viewpoint = new Viewpoint(this.camera, this.orbit);
    this.show(footage);
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Play this from its start, seen from its first view. */
  show(footage: Footage): void {
    this.footage = footage;
    this.clock = new Clock(footage);
    this.picker = new Picker(footage);
    this.picked = -1;
    // The stage's origin is what the first view looks at.
    const { eye, target } = footage.camera;
    this.camera.position.fromArray(eye.map((part, axis) => part - target[axis]!));
    this.camera.lookAt(new Vector3());
    this.orbit.target.set(0, 0, 0);
    this.orbit.maxPolarAngle = footage.bodies.some((body) => body.floor)
      ? 0.495 * Math.PI
      : Math.PI;
    const distance = this.camera.position.length();
    this.orbit.minDistance = 0.02 * distance;
    this.orbit.maxDistance = 12 * distance;
    this.orbit.saveState();
    this.stage?.dispose();
    this.stage = new Stage(this.renderer, footage, this.images, this.camera);
    this.resize();
  }

  /** Begin with this level, and show no better ones; 0 is the best. */
  spend(level: number): void {
    this.level = this.best = Math.min(Math.max(Math.round(level) || 0, BEST), CHEAPEST);
    this.resize();
  }

  /** Draw the bodies too that the footage did not have before. */
  takeIn(): void {
    this.stage?.takeIn();
    this.state = "";
  }

  /** The same, where bodies have images that the footage did not have before. */
  restage(images: DataArrayTexture): void {
    const { position, quaternion } = this.camera;
    const [place, turn] = [position.clone(), quaternion.clone()];
    this.images = images;
    this.stage?.dispose();
    // The lamp stands where the first view wants it.
    const { eye, target } = this.footage.camera;
    position.fromArray(eye.map((part, axis) => part - target[axis]!));
    this.camera.lookAt(new Vector3());
    this.camera.updateMatrixWorld();
    this.stage = new Stage(this.renderer, this.footage, images, this.camera);
    position.copy(place);
    quaternion.copy(turn);
    this.resize();
  }

  /** The row of the body at a place of the canvas [CSS px]; -1 for none. */
  bodyAt(x: number, y: number): number {
    if (this.stage === null) return -1;
    const { clientWidth, clientHeight } = this.canvas;
    const ray = new Raycaster();
    ray.setFromCamera(
      new Vector2((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight),
      this.camera,
    );
    const hit = this.picker.pick(this.poses, ray.ray.origin.toArray(), ray.ray.direction.toArray());
    return hit?.row ?? -1;
  }

  /** Look at the body that is picked, or at all as at first. */
  focus(): void {
    const at = 4 * TEXELS * this.picked;
    const radius = this.picker.radius(this.picked);
    if (this.poses[at + 3] !== 1 || radius === 0) this.resetView();
    else this.viewpoint.focus(new Vector3().fromArray(this.poses, at), radius);
  }

  /** Draw calls and triangles of the last picture, of all its passes; and its level. */
  get drawn(): { calls: number; triangles: number; level: number } {
    const { calls, triangles } = this.renderer.info.render;
    return { calls, triangles, level: this.isResting ? this.levelAtRest : this.level };
  }

  /** What is drawn: places and quaternions as `Footage.fill` fills them. */
  get poses(): Float32Array {
    return this.stage === null ? new Float32Array(0) : numbers(this.stage.uniforms.poses.value);
  }

  /** Go on for ever. */
  start(): void {
    const turn = (now: number): void => {
      requestAnimationFrame(turn);
      this.update(now);
    };
    requestAnimationFrame(turn);
  }

  /** Show everything above what covers so much of the lower edge [CSS px]. */
  keepFree(height: number): void {
    if (height === this.covered) return;
    this.covered = height;
    this.resize();
  }

  /** Back to where it was seen from at first. */
  resetView(): void {
    this.orbit.reset();
  }

  private update(now: number): void {
    this.onUpdate();
    // A tab that was in the background does not jump ahead.
    this.clock.advance(Math.min((now - this.last) / 1000, 0.25));
    const duration = now - this.last;
    this.last = now;
    this.orbit.update();
    const state = [
      this.clock.time,
      this.explode,
      this.picked,
      this.turnsOfView(),
      this.level,
    ].join();
    const looks = this.stage?.uniforms.pieces.value;
    const isPainted =
      looks !== undefined &&
      this.painter?.paint(numbers(looks), this.clock.time, this.picked) === true;
    if (isPainted) looks.needsUpdate = true;
    if (state !== this.state || isPainted) {
      this.adapt(duration);
      this.rest(false);
      this.state = state;
      this.picture = 0;
      this.still = now;
    } else if (
      !this.isResting &&
      this.level > this.levelAtRest &&
      now - this.still > (this.clock.playing ? WAITS : REST)
    ) {
      this.rest(true);
      this.state = state;
      this.picture = 0;
    } else if (!this.isResting && this.level > this.levelAtRest) {
      // Sharper pictures of it come soon.
      return;
    } else if (this.picture >= PICTURES || (now - this.still > PATIENCE && this.picture >= 4)) {
      this.durations = [];
      return;
    }
    this.draw();
  }

  /**
   * Number of times that the eye or what it looks at has moved: the controls round both in every
   * picture.
   */
  private turnsOfView(): number {
    const { camera, orbit, eye, target } = this;
    const moved = camera.position.distanceTo(eye) + orbit.target.distanceTo(target);
    if (moved > SAME_VIEW * camera.position.distanceTo(orbit.target)) {
      eye.copy(camera.position);
      target.copy(orbit.target);
      this.turns++;
    }
    return this.turns;
  }

  private draw(): void {
    const distance = this.camera.position.distanceTo(this.orbit.target);
    this.camera.near = 0.01 * distance;
    this.camera.far = 100 * distance;
    this.camera.updateProjectionMatrix();
    this.renderer.info.reset();
    this.stage?.pose(this.clock.time, this.explode);
    this.stage?.draw(this.camera, this.orbit.target, this.quality, this.picture);
    this.picture++;
    this.onDraw(this.picture >= 4 && (this.isResting || this.level <= this.levelAtRest));
  }

  private get levelAtRest(): number {
    return Math.min(this.best, SHARP);
  }

  private get quality(): (typeof LEVELS)[number] {
    return LEVELS[this.drawn.level]!;
  }

  /** Nothing moves: there is time for a sharper picture. */
  private rest(isResting: boolean): void {
    if (isResting === this.isResting) return;
    this.isResting = isResting;
    this.durations = [];
    if (this.level > this.levelAtRest) this.resize();
  }

  /** Spend less on a picture where the last ones took too long, and more where they did not. */
  private adapt(duration: number): void {
    this.durations.push(duration);
    if (this.durations.length < (this.level > this.best ? FOR_MORE : FOR_LESS)) return;
    const median = this.durations.sort((a, b) => a - b)[this.durations.length >> 1]!;
    this.durations = [];
    const level = this.level;
    if (median > TOO_LONG) this.best = this.level = Math.min(level + 1, CHEAPEST);
    else if (median <= SHORT && level > this.best) this.level--;
    if (this.level !== level) this.resize();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const [width, height] = [Math.max(clientWidth, 1), Math.max(clientHeight, 1)];
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, this.quality.pixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    const free = Math.max(height - this.covered, height / 4);
    const wider = Math.max(1, (ASPECT * free) / width) * (height / free);
    const halfHeight = Math.tan((this.footage.camera.fieldOfView * Math.PI) / 360) * wider;
    if (this.stage !== null) this.stage.raised = (0.5 * (height - free)) / height;
    this.camera.fov = (Math.atan(halfHeight) * 360) / Math.PI;
    this.stage?.resize(this.canvas.width, this.canvas.height);
    this.state = "";
  }
}
