// Types of scenes, under the names that the package gives them.
export type {
  AnchorDesc, BodyDesc, BondsDesc, BreakingDesc, KeyframeDesc, Material as MaterialDesc, MaterialDesc as StrengthNumbers, MotionDesc,
  OwnLook, PartDesc, PatternDesc, SceneDesc, ShapeDesc, SolverDesc, StartsDesc, StrengthDesc,
} from "./scene";
