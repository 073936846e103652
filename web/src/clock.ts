// The clock: the frame that plays at a time.

/** What a clock runs over. */
export interface Frames {
  /** Last frame. */
  readonly frames: number;
  readonly fps: number;
  /** Whether more frames come: the end is waited at, else it stops the clock. */
  readonly grows: boolean;
}

/** The time of a recording, in frames. */
export class Clock {
  /** From 0 to the last frame; a fraction lies between two frames. */
  time = 0;
  playing = false;
  /** Seconds of the recording in a second. */
  speed = 1;
  /** Whether it begins anew at the end. */
  loop = false;

  constructor(private readonly film: Frames) {}

  /** Last frame. */
  get frames(): number {
    return this.film.frames;
  }

  /** The frame that is shown: bodies are born and die at whole frames. */
  get frame(): number {
    return Math.floor(this.time);
  }

  /** Let time pass [s], if there is any; at the end the recording stops. */
  advance(seconds: number): void {
    // A page's first picture may be older than the clock that it is drawn by.
    if (!this.playing || seconds < 0) return;
    this.time = Math.min(this.time + seconds * this.speed * this.film.fps, this.frames);
    if (this.time < this.frames || this.film.grows) return;
    if (this.loop) this.time = 0;
    else this.playing = false;
  }

  /** Play from here, or from the start if this is the end. */
  toggle(): void {
    this.playing = !this.playing;
    if (this.playing && this.time >= this.frames && !this.film.grows) this.time = 0;
  }

  /** Go to a time in frames and stay there. */
  seek(time: number): void {
    this.playing = false;
    this.time = Math.min(Math.max(time, 0), this.frames);
  }

  /** Go to the next whole frame in a direction, 1 or -1. */
  step(direction: number): void {
    this.seek(direction > 0 ? Math.floor(this.time) + 1 : Math.ceil(this.time) - 1);
  }
}
