// A shader over the whole screen.
import {
  Camera, GLSL3, type IUniform, Mesh, PlaneGeometry, RawShaderMaterial, Scene, type WebGLRenderer,
  type WebGLRenderTarget,
} from "three";
import { SCREEN_VERTEX } from "./shaders/screen";

export class ScreenPass {
  private readonly scene = new Scene();
  private readonly camera = new Camera();

  constructor(
    fragmentShader: string,
    readonly uniforms: Record<string, IUniform>,
  ) {
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: SCREEN_VERTEX,
      fragmentShader,
      uniforms,
      depthTest: false,
      depthWrite: false,
    });
    const mesh = new Mesh(new PlaneGeometry(2, 2), material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  /** Let the driver compile beside the page. */
  compile(renderer: WebGLRenderer): void {
    renderer.compile(this.scene, this.camera);
  }

  /** Draw into a target, or onto the page. */
  draw(renderer: WebGLRenderer, target: WebGLRenderTarget | null): void {
    renderer.setRenderTarget(target);
    renderer.render(this.scene, this.camera);
  }
}
