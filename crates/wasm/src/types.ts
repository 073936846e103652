/** One frame; see crates/frangible/src/report.rs. */
export interface StepReport {
  /** Counts from 1. */
  frame: number;
  /** At the end of the frame [s]. */
  time: number;
  /** Living bodies. */
  bodies: number;
  asleep: number;
  pairs_left_out: number;
  short_of_substeps: number;
  short_of_impacts: number;
  /** Of all dynamic bodies [kg]. */
  mass: number;
  /** [J] */
  energy: {
    kinetic: number;
    potential: number;
    total: number;
    work: number;
    banked: number;
    gain: number;
    causes: Record<
      "work" | "collision" | "contact" | "friction" | "projection" | "fracture" | "balance" | "flight",
      number
    >;
  };
  momentum: {
    linear: [number, number, number];
    angular: [number, number, number];
    linear_error: number;
    angular_error: number;
  };
  balance: { islands: number; paid: number; scaled: number; shortened: number; removed: number };
  impulses: { applied: number; clamped: number; discarded: number; withheld: number };
  fractures: Fracture[];
  /** Of the blows that broke nothing the one that came nearest to what its body bears [N s]. */
  borne?: {
    body: number;
    name: string;
    striker: string;
    point: [number, number, number];
    impulse: number;
    bears: number;
  };
  quarantined: { body: number; cause: string }[];
  /** Names of the stages and how long they took [ms]. */
  stages: [string, number][];
}

/** A body broke. */
export interface Fracture {
  /** Ids: of the body, which lives no more, of what struck it, and of its pieces. */
  body: number;
  striker: number;
  fragments: number[];
  /** World frame [m]. */
  point: [number, number, number];
  /** [N s] */
  impulse: number;
  borne: number;
  /** [J] */
  energy: number;
  wanted?: number;
  /** As many came, without loose parts and slivers below a hundredth of the mean piece. */
  counted?: number;
  imbalance: { mass: number; momentum: number; angular_momentum: number; kinetic_energy: number };
}
