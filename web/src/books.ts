// The books of a recording: energy by cause after each step, and its breaks.
import { floats } from "./meshes";
import type { Strike } from "./recording";
import type { Blob32 } from "./streams";

/** What changes the energy of dynamic bodies, in the order of the streams. */
export const CAUSES = [
  "work",
  "collision",
  "contact",
  "friction",
  "projection",
  "fracture",
  "balance",
  "flight",
] as const;
export type Cause = (typeof CAUSES)[number] | "started";

/** Of all dynamic bodies after a step [J]. */
export interface EnergyOfFrame {
  frame: number;
  kinetic: number;
  /** Relative to the world's origin. */
  potential: number;
  /** Change in this frame by cause; what was there when waiting bodies started is one. */
  changes: Record<Cause, number>;
}

export interface Books {
  energy: EnergyOfFrame[];
  strikes: Strike[];
  /** Upward acceleration of free flight [m/s^2]; `null` where nobody knows it. */
  gravity: number | null;
}

/** Add what a blob tells. */
export function readBooks(blob: Blob32, into: Books): void {
  const [kinetic, potential, , , , started, ...causes] = blob.columns("energy").map(floats);
  blob.column("energy_frames").forEach((frame, row) => {
    const changes = { started: started![row]! } as Record<Cause, number>;
    CAUSES.forEach((cause, column) => (changes[cause] = causes[column]![row]!));
    into.energy.push({ frame, kinetic: kinetic![row]!, potential: potential![row]!, changes });
  });
  const [body, striker, pieces] = ["break_body", "break_striker", "break_pieces"].map((name) =>
    blob.column(name),
  );
  const [impulse, energy] = blob.columns("break_figures").map(floats);
  blob.column("break_frame").forEach((frame, row) => {
    into.strikes.push({
      frame,
      body: body![row]!,
      striker: striker![row]!,
      pieces: pieces![row]!,
      impulse: impulse![row]!,
      energy: energy![row]!,
    });
  });
}
