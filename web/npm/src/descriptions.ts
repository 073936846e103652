// Types of scenes, under the names that the package gives them.
export type {
  AnchorDesc, BodyDesc, BondsDesc, BreakingDesc, KeyframeDesc, LookDesc, MaterialDesc, MotionDesc,
  PartDesc, PatternDesc, SceneDesc, ShapeDesc,
  SolverDesc, StartsDesc, StrengthDesc,
} from "./scene";
