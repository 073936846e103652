// Says in a sentence what is shown, to those who do not see it.

/** What rests that long is said [ms]. */
const REST = 350;
/** While it plays, no more often than that [ms]. */
const PAUSE = 4000;

export class Announcer {
  private said = "";
  private pending = "";
  private timer = 0;
  private last = -PAUSE;

  /** `region` is a live one. */
  constructor(private readonly region: HTMLElement) {}

  /** What is shown now. */
  tell(sentence: string, playing: boolean): void {
    if (sentence === this.pending) return;
    this.pending = sentence;
    const now = performance.now();
    if (playing) {
      // Frames go by faster than words.
      if (this.timer === 0)
        this.timer = window.setTimeout(() => this.say(), Math.max(PAUSE - (now - this.last), REST));
      return;
    }
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.say(), REST);
  }

  private say(): void {
    this.timer = 0;
    this.last = performance.now();
    if (this.pending === this.said) return;
    this.said = this.pending;
    this.region.textContent = this.pending;
  }
}
