// Marks over the time line, one for each break: the more pieces, the taller.
import type { Break } from "./recording";

/** Half the width of a slider's knob: the time line begins and ends there [CSS px]. */
export const KNOB = 8;

export function drawMarks(
  canvas: HTMLCanvasElement,
  breaks: readonly Break[],
  frames: number,
): void {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  if (context === null) return;
  context.scale(ratio, ratio);
  context.fillStyle = "#ffb067";
  const most = Math.max(...breaks.map(({ pieces }) => pieces), 2);
  for (const { frame, pieces } of breaks) {
    const tall = height * (0.35 + (0.65 * Math.log(Math.max(pieces, 1))) / Math.log(most));
    context.fillRect(
      KNOB + ((width - 2 * KNOB) * frame) / Math.max(frames, 1) - 1,
      height - tall,
      2,
      tall,
    );
  }
}
