// From light to a picture, and from several pictures of the same to a smoother one.
import {
  FloatType, NearestFilter, type Texture, type WebGLRenderer, WebGLRenderTarget,
} from "three";
import { ScreenPass } from "./screen_pass";
import { COPY_FRAGMENT, FILM_FRAGMENT } from "./shaders/screen";

export class Film {
  private readonly targets = [0, 1].map(
    () =>
      new WebGLRenderTarget(1, 1, {
        type: FloatType,
        depthBuffer: false,
        minFilter: NearestFilter,
        magFilter: NearestFilter,
      }),
  ) as [WebGLRenderTarget, WebGLRenderTarget];
  private readonly uniforms = {
    radiances: { value: null as Texture | null },
    before: { value: null as Texture | null },
    weight: { value: 1 },
  };
  private readonly develop = new ScreenPass(FILM_FRAGMENT, this.uniforms);
  private readonly copy = new ScreenPass(COPY_FRAGMENT, this.uniforms);

  constructor(private readonly renderer: WebGLRenderer) {}

  resize(width: number, height: number): void {
    for (const target of this.targets) target.setSize(width, height);
  }

  /** See `ScreenPass`. */
  compile(): void {
    for (const pass of [this.develop, this.copy]) pass.compile(this.renderer);
  }

  dispose(): void {
    for (const target of this.targets) target.dispose();
  }

  /** Show the mean of the pictures from number 0 to this one. */
  show(radiances: Texture, picture: number): void {
    const [before, after] =
      picture % 2 === 0 ? this.targets : ([this.targets[1], this.targets[0]] as const);
    this.uniforms.radiances.value = radiances;
    this.uniforms.before.value = before.texture;
    this.uniforms.weight.value = 1 / (picture + 1);
    this.develop.draw(this.renderer, after);
    this.uniforms.before.value = after.texture;
    this.copy.draw(this.renderer, null);
  }
}
