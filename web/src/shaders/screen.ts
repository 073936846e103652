// Shaders over the whole screen: ambient occlusion, and the film.

export const SCREEN_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
out vec2 screen;
void main() {
  screen = position.xy;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}
`;

/**
 * How open the half sphere over each surface is to what is near: samples of depth within a reach.
 */
export const AMBIENT_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 screen;
uniform sampler2D depths;
uniform sampler2D normals;
uniform mat4 projection;
uniform mat4 inverseProjection;
/** How far is looked for what stands in the way [m]. */
uniform float reach;
uniform int taps;
uniform float seed;
out vec4 open;

vec3 viewPoint(vec2 at, float depth) {
  vec4 point = inverseProjection * vec4(2.0 * vec3(at, depth) - 1.0, 1.0);
  return point.xyz / point.w;
}

void main() {
  vec2 at = 0.5 + 0.5 * screen;
  float depth = texture(depths, at).r;
  if (depth >= 1.0) { open = vec4(1.0); return; }
  vec3 n = normalize(2.0 * texture(normals, at).rgb - 1.0);
  vec3 point = viewPoint(at, depth) + n * 0.02 * reach;

  // Two vectors across the normal (Duff et al. 2017).
  float s = n.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (s + n.z);
  float b = n.x * n.y * a;
  vec3 across = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
  vec3 along = vec3(b, s + n.y * n.y * a, -n.y);

  // Every pixel of a square of four by four turns the pattern by an angle of its own.
  ivec2 tile = ivec2(gl_FragCoord.xy) & 3;
  float turn = 6.2831853 * (float((tile.x * 5 + tile.y * 7) & 15) / 16.0 + seed);
  float closed = 0.0;
  for (int i = 0; i < taps; i++) {
    float u = (float(i) + 0.5) / float(taps);
    float angle = 2.39996323 * float(i) + turn;
    float away = fract(0.618034 * float(i) + 0.25 + seed + turn * 0.37);
    vec3 direction = sqrt(u) * (cos(angle) * across + sin(angle) * along) + sqrt(1.0 - u) * n;
    vec3 sampled = point + direction * reach * mix(0.06, 1.0, away * away);
    vec4 clip = projection * vec4(sampled, 1.0);
    vec2 where = 0.5 + 0.5 * clip.xy / clip.w;
    vec3 met = viewPoint(where, texture(depths, where).r);
    float before = met.z - sampled.z;
    closed += before > 0.0 ? 1.0 - smoothstep(0.7 * reach, 1.6 * reach, before) : 0.0;
  }
  open = vec4(1.0 - closed / float(taps));
}
`;

/** The mean over the square of four by four, of what lies at the same depth. */
export const SMOOTH_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 screen;
uniform sampler2D ambient;
uniform sampler2D depths;
uniform mat4 inverseProjection;
uniform float reach;
out vec4 open;

float viewDepth(vec2 at) {
  vec4 point = inverseProjection * vec4(2.0 * at - 1.0, 2.0 * texture(depths, at).r - 1.0, 1.0);
  return point.z / point.w;
}

void main() {
  vec2 at = 0.5 + 0.5 * screen;
  vec2 pixel = 1.0 / vec2(textureSize(ambient, 0));
  float here = viewDepth(at);
  float total = 0.0, weights = 0.0;
  for (int y = -2; y < 2; y++) for (int x = -2; x < 2; x++) {
    vec2 there = at + (vec2(x, y) + 0.5) * pixel;
    float weight = 1e-3 + exp(-8.0 * abs(viewDepth(there) - here) / reach);
    total += weight * texture(ambient, there).r;
    weights += weight;
  }
  open = vec4(total / weights);
}
`;

/** The film curve of Narkowicz (2015) and the sRGB encoding, then the mean with what was there. */
export const FILM_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 screen;
uniform sampler2D radiances;
uniform sampler2D before;
/** Weight of the new picture. */
uniform float weight;
out vec4 shown;
void main() {
  vec2 at = 0.5 + 0.5 * screen;
  vec3 x = 0.58 * texture(radiances, at).rgb;
  vec3 film = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  vec3 bright = 1.055 * pow(film, vec3(1.0 / 2.4)) - 0.055;
  vec3 encoded = mix(bright, 12.92 * film, lessThanEqual(film, vec3(0.0031308)));
  shown = vec4(weight < 1.0 ? mix(texture(before, at).rgb, encoded, weight) : encoded, 1.0);
}
`;

/** Shows a picture. */
export const COPY_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 screen;
uniform sampler2D before;
out vec4 shown;
void main() { shown = texture(before, 0.5 + 0.5 * screen); }
`;
