// Ambient occlusion from depths and normals, at half the width and height of the picture.
import {
  type BufferGeometry, type Camera, DoubleSide, GLSL3, Mesh, RawShaderMaterial, Scene, type
  WebGLRenderer, WebGLRenderTarget,
} from "three";
import { depthTexture } from "./lamp";
import { ScreenPass } from "./screen_pass";
import { NORMAL_FRAGMENT, NORMAL_VERTEX } from "./shaders/place";
import { AMBIENT_FRAGMENT, SMOOTH_FRAGMENT } from "./shaders/screen";
import type { Uniforms } from "./uniforms";

export class Occlusion {
  private readonly scene = new Scene();
  private readonly surfaces = new WebGLRenderTarget(1, 1, { depthTexture: depthTexture(1, 1) });
  private readonly rough = new WebGLRenderTarget(1, 1, { depthBuffer: false });
  private readonly smooth = new WebGLRenderTarget(1, 1, { depthBuffer: false });
  private readonly sample: ScreenPass;
  private readonly blur: ScreenPass;

  constructor(
    private readonly renderer: WebGLRenderer,
    solid: BufferGeometry,
    uniforms: Uniforms,
  ) {
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: NORMAL_VERTEX,
      fragmentShader: NORMAL_FRAGMENT,
      uniforms: {
        poses: uniforms.poses,
        view: uniforms.view,
        viewProjection: uniforms.viewProjection,
      },
      side: DoubleSide,
    });
    const mesh = new Mesh(solid, material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    const { projection, inverseProjection, reach, taps, seed } = uniforms;
    const depths = { value: this.surfaces.depthTexture };
    this.sample = new ScreenPass(AMBIENT_FRAGMENT, {
      depths,
      normals: { value: this.surfaces.texture },
      projection,
      inverseProjection,
      reach,
      taps,
      seed,
    });
    this.blur = new ScreenPass(SMOOTH_FRAGMENT, {
      depths,
      ambient: { value: this.rough.texture },
      inverseProjection,
      reach,
    });
    uniforms.ambient.value = this.smooth.texture;
  }

  resize(width: number, height: number): void {
    for (const target of [this.surfaces, this.rough, this.smooth])
      target.setSize(Math.ceil(width / 2), Math.ceil(height / 2));
  }

  dispose(): void {
    for (const target of [this.surfaces, this.rough, this.smooth]) target.dispose();
  }

  /** Let the driver compile beside the page. */
  compile(camera: Camera): void {
    this.renderer.compile(this.scene, camera);
    for (const pass of [this.sample, this.blur]) pass.compile(this.renderer);
  }

  draw(camera: Camera): void {
    this.renderer.setRenderTarget(this.surfaces);
    this.renderer.clear();
    this.renderer.render(this.scene, camera);
    this.sample.draw(this.renderer, this.rough);
    this.blur.draw(this.renderer, this.smooth);
  }
}
