// Fragment shaders: the light of the gallery's pictures (`python/frangible/render/picture.py`),
// without rays.
import { TABLES } from "./place";

/**
 * Reads the lamp's shadow map; softens with the distance from what casts the shadow (Fernando
 * 2005).
 */
const LAMP = /* glsl */ `
uniform sampler2D lampDepth;
uniform sampler2D glassDepth;
uniform mat4 lampMatrix;
uniform vec3 lamp;
/** Half the width and the depth of what the lamp sees, and the width of a texel [m]. */
uniform vec3 lampReach;
uniform bool hasGlass;
uniform int taps;
uniform float seed;

const float LAMP_RADIUS = 0.06;
const float GLASS_SHADOW = 0.78;

float noise(vec2 pixel) {
  return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))) + seed);
}

/** Each pixel turns the samples by an angle of its own. */
float patternTurn() {
  return 6.2831853 * noise(gl_FragCoord.xy);
}

vec2 disk(int i, int count, float turn) {
  float angle = 2.39996323 * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(count)) * vec2(cos(angle), sin(angle));
}

/**
 * Share of the lamp that is seen from a place of its map: first how far away is what hides it, then
 * how much that hides.
 */
float softened(vec3 at, vec3 n, float facing) {
  // How far the surface itself rises towards the lamp across the map, in the map's units.
  vec3 across = vec3(lampMatrix[0][0], lampMatrix[1][0], lampMatrix[2][0]);
  vec3 along = vec3(lampMatrix[0][1], lampMatrix[1][1], lampMatrix[2][1]);
  vec2 slope = vec2(dot(n, normalize(across)), dot(n, normalize(along))) / max(facing, 0.15)
    * lampReach.x / lampReach.y;

  float turn = patternTurn();
  float wide = min(LAMP_RADIUS * lampReach.y * 0.12 / lampReach.x, 0.06);
  float share = 1.0;
  float above = 0.0, blockers = 0.0;
  for (int i = 0; i < taps; i++) {
    vec2 offset = wide * 0.5 * disk(i, taps, turn);
    float surface = at.z + 2.0 * dot(offset, slope);
    float depth = texture(lampDepth, at.xy + offset).r;
    if (depth < surface) { above += surface - depth; blockers += 1.0; }
  }
  if (blockers > 0.0) {
    float radius = clamp(
      LAMP_RADIUS * above / blockers * lampReach.y / lampReach.x, lampReach.z / lampReach.x, wide);
    float open = 0.0;
    for (int i = 0; i < taps; i++) {
      vec2 offset = radius * 0.5 * disk(i, taps, turn);
      open += step(at.z + 2.0 * dot(offset, slope), texture(lampDepth, at.xy + offset).r);
    }
    share = open / float(taps);
  }
  return share;
}

/** Share of the lamp's light that arrives at a point. */
float lampShare(vec3 point, vec3 n) {
  float facing = dot(n, lamp);
  if (facing <= 0.0) return 0.0;
  vec3 lifted = point + n * lampReach.z * (1.0 + 1.5 * sqrt(1.0 - facing * facing));
  vec3 at = (lampMatrix * vec4(lifted, 1.0)).xyz * 0.5 + 0.5;
  vec2 away = abs(at.xy - 0.5) * 2.0;
  if (max(away.x, away.y) >= 1.0) return 1.0;

  float share = 1.0;
  if (taps > 1) share = softened(at, n, facing);
  else share = step(at.z, texture(lampDepth, at.xy).r);
  if (hasGlass) {
    float clear = 0.0, turn = patternTurn();
    for (int i = 0; i < 4; i++)
      clear += step(
        at.z, texture(glassDepth, at.xy + lampReach.z / lampReach.x * disk(i, 4, turn)).r);
    share *= mix(GLASS_SHADOW, 1.0, clear / 4.0);
  }
  return mix(share, 1.0, smoothstep(0.85, 1.0, max(away.x, away.y)));
}
`;

const SKY = /* glsl */ `
uniform sampler2D ambient;
uniform bool hasAmbient;
uniform vec2 pixels;

const vec3 LAMP_COLOUR = vec3(2.55, 2.25, 1.85);
const vec3 SKY_COLOUR = vec3(0.56, 0.68, 0.88);
const vec3 BOUNCE_COLOUR = vec3(0.16, 0.145, 0.13);
const vec3 FLOOR_COLOUR = vec3(0.25, 0.26, 0.28);
const vec3 HAZE_COLOUR = vec3(0.52, 0.57, 0.64);
const vec3 ZENITH_COLOUR = vec3(0.20, 0.27, 0.38);

vec3 backdrop(vec3 direction) {
  return mix(HAZE_COLOUR, ZENITH_COLOUR, clamp(2.2 * direction.y, 0.0, 1.0));
}

/** Light of the sky over the half sphere: its lower part sees the floor instead. */
vec3 skyLight(vec3 n) {
  float open = hasAmbient ? texture(ambient, gl_FragCoord.xy / pixels).r : 0.9;
  float free = open * (0.5 + 0.5 * n.y);
  float height = 0.35 + 0.65 * mix(0.75, 0.97, max(n.y, 0.0));
  return free * height * SKY_COLOUR + (1.0 - free) * BOUNCE_COLOUR;
}
`;

/**
 * Grain of wood and gravel in concrete, drawn by position as `python/frangible/render/textures.py`
 * does.
 */
const GRAIN = /* glsl */ `
float hashed(ivec3 at) {
  uvec3 v = uvec3(at) * 1664525u + 1013904223u;
  v += v.yzx * v.zxy;
  v ^= v >> 16u;
  v += v.yzx * v.zxy;
  return float(v.x >> 8u) / 16777216.0;
}

float valueNoise(vec3 point) {
  ivec3 cell = ivec3(floor(point));
  vec3 part = fract(point);
  part *= part * (3.0 - 2.0 * part);
  vec4 low = vec4(
    hashed(cell), hashed(cell + ivec3(1, 0, 0)),
    hashed(cell + ivec3(0, 1, 0)), hashed(cell + ivec3(1, 1, 0)));
  cell.z += 1;
  vec4 high = vec4(
    hashed(cell), hashed(cell + ivec3(1, 0, 0)),
    hashed(cell + ivec3(0, 1, 0)), hashed(cell + ivec3(1, 1, 0)));
  vec4 four = mix(low, high, part.z);
  vec2 two = mix(four.xy, four.zw, part.y);
  return mix(two.x, two.y, part.x);
}

vec3 wood(vec3 p) {
  float wander = 0.5 * valueNoise(p * vec3(1.3, 9.0, 9.0))
    + 0.12 * valueNoise(p * vec3(6.0, 60.0, 60.0));
  float late = fract(length(p.yz + vec2(0.09, 0.05)) / 0.011 + 2.0 * wander);
  float fibre = 0.06 * (valueNoise(p * vec3(25.0, 900.0, 900.0)) - 0.5);
  return 1.0 + fibre - late * late * late * vec3(0.34, 0.44, 0.50);
}

vec3 concrete(vec3 p, bool inside) {
  float sand = 0.16 * (valueNoise(p / 0.005) - 0.5) + 0.14 * (valueNoise(p / 0.15) - 0.5);
  if (!inside) return vec3(1.0 + sand);
  float gravel = clamp((valueNoise(p / 0.022) - 0.56) * 9.0, 0.0, 1.0);
  return 1.0 + sand + gravel * (vec3(-0.34, -0.32, -0.28) + 0.45 * valueNoise(p / 0.055 + 17.0));
}
`;

const SHADE = /* glsl */ `
/** The lamp's reflection; a negative roughness is that of pictures. */
float sheenOf(float gloss, float metallic, float roughness) {
  vec2 power = vec2(48.0, 140.0);
  vec2 strength = vec2(0.14, 0.9);
  if (roughness >= 0.0) {
    // Blinn's exponent for it (Walter et al. 2007), with the same light in the whole reflection.
    float wide = max(2.0 / pow(max(roughness, 0.08), 4.0) - 2.0, 0.0);
    strength *= (wide + 2.0) / (power + 2.0);
    power = vec2(wide);
  }
  return dot(strength * pow(vec2(max(gloss, 1e-4)), power), vec2(1.0 - metallic, metallic));
}

/** Light from a point whose surface is seen with a normal of its own. */
vec3 shade(
  vec3 albedo, float metallic, float roughness, vec3 point, vec3 flatNormal, vec3 n, vec3 ray
) {
  vec3 light = lampShare(point, flatNormal) * LAMP_COLOUR;
  float facing = max(dot(n, lamp), 0.0);
  float sheen = sheenOf(max(dot(n, normalize(lamp - ray)), 0.0), metallic, roughness);
  vec3 mirrored = albedo * backdrop(reflect(ray, n)) * metallic;
  return albedo * (light * facing + skyLight(n)) * (1.0 - 0.6 * metallic)
    + mirrored + sheen * light;
}
`;

const HEAD = /* glsl */ `
precision highp float;
precision highp int;
uniform vec3 eye;
out vec4 radiance;
`;

/** Bodies: what is solid, or one of two layers of what is clear. */
export const SURFACE_FRAGMENT = /* glsl */ `
${HEAD}
in vec3 world;
in vec3 normalWorld;
in vec3 pointBody;
flat in uvec2 bodyAndMaterial;
uniform sampler2D pieces;
uniform sampler2D materials;
#ifdef SKINNED
precision highp sampler2DArray;
uniform sampler2DArray images;
in vec2 imagePlace;
in vec4 corner;
#endif
${TABLES}${LAMP}${SKY}${GRAIN}${SHADE}

// What the tables say of a body and its material.
vec4 colour, finish, shine, relief;
bool keepsCorners;

void readTables() {
  uvec2 ids = bodyAndMaterial;
  colour = entry(materials, 4u * ids.y);
  finish = entry(materials, 4u * ids.y + 1u);
  shine = entry(materials, 4u * ids.y + 2u);
  relief = entry(materials, 4u * ids.y + 3u);
  // A factor of the material's colour, or a colour in place of all that the material says.
  vec4 look = entry(pieces, 2u * ids.x);
  uint flags = uint(look.w + 0.5);
  keepsCorners = (flags & 1u) == 0u;
  if (keepsCorners) {
    colour.rgb *= look.rgb;
  } else {
    colour = vec4(look.rgb, min(colour.a, 0.3));
    finish = vec4(0.0, 0.0, finish.z, -1.0);
    shine.rgb = vec3(0.0);
    relief = vec4(0.8, -1.0, -1.0, -1.0);
  }
  // What is picked glows.
  if ((flags & 2u) != 0u) shine.rgb += vec3(0.62, 0.26, 0.03);
}

/** What the mesh's file lays on the material. */
struct Skin {
  /** Factors of colour and opacity. */
  vec4 colour;
  /** Factor of the light that it shines with. */
  vec3 emission;
  /** Factors of roughness and metallic. */
  vec2 surface;
  vec3 normal;
};

#ifdef SKINNED
vec3 linear(vec3 encoded) {
  vec3 high = pow((encoded + 0.055) / 1.055, vec3(2.4));
  return mix(high, encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

vec4 laidOn(float image) {
  vec4 texel = texture(images, vec3(imagePlace, max(image, 0.0)));
  return image >= 0.0 ? texel : vec4(1.0);
}

/**
 * A normal of the image, in the frame that its coordinates span on the surface (Mikkelsen 2010).
 */
vec3 bent(vec3 n, vec3 tilt) {
  vec3 dx = dFdx(world), dy = dFdy(world);
  vec2 du = dFdx(imagePlace), dv = dFdy(imagePlace);
  vec3 across = cross(dy, n), along = cross(n, dx);
  vec3 tangent = across * du.x + along * dv.x;
  vec3 bitangent = across * du.y + along * dv.y;
  float size = max(dot(tangent, tangent), dot(bitangent, bitangent));
  if (size <= 0.0) return n;
  return normalize((tangent * tilt.x + bitangent * tilt.y) * inversesqrt(size) + n * tilt.z);
}
#endif

Skin skin(vec3 n) {
#ifdef SKINNED
  vec4 image = laidOn(finish.w);
  vec4 surface = laidOn(relief.y);
  vec3 tilted = bent(n, 2.0 * laidOn(relief.z).xyz - 1.0);
  vec4 own = keepsCorners ? corner : vec4(vec3(1.0), corner.a);
  vec4 laid = vec4(linear(image.rgb), image.a) * own;
  return Skin(laid, linear(laidOn(relief.w).rgb), surface.gb, relief.z >= 0.0 ? tilted : n);
#else
  return Skin(vec4(1.0), vec3(1.0), vec2(1.0), n);
#endif
}

vec3 grained(vec3 albedo) {
  if (finish.y == 0.0) return albedo;
  vec3 point = turned(entry(pieces, 2u * bodyAndMaterial.x + 1u), pointBody);
  return albedo * (finish.y == 1.0 ? wood(point) : concrete(point, finish.z > 0.5));
}

void main() {
  readTables();
  vec3 n = normalize(normalWorld) * (gl_FrontFacing ? 1.0 : -1.0);
  vec3 ray = normalize(world - eye);
  Skin laid = skin(n);
  vec3 albedo = colour.rgb * laid.colour.rgb;
  vec3 emission = shine.rgb * laid.emission;
  float metallic = finish.x * laid.surface.y;
  float roughness = relief.x * laid.surface.x;
#ifdef GLASS
  if (shine.a == 2.0) {
    // Surfaces of less than full opacity.
    float opaque = laid.colour.a * (1.0 - colour.a);
#if GLASS == 1
    radiance = vec4(vec3(1.0 - opaque), 1.0);
#else
    vec3 lit = shade(albedo, metallic, roughness, world, n, laid.normal, ray);
    radiance = vec4(opaque * (lit + emission), 1.0);
#endif
    return;
  }
  // Schlick's formula, for both sides of the glass.
  float clear = colour.a;
  float cosine = clamp(-dot(n, ray), 0.0, 1.0);
  float reflectance = 0.045 + 0.955 * pow(1.0 - cosine, 5.0);
#if GLASS == 1
  radiance = vec4(sqrt(clear) * (1.0 - reflectance) * pow(albedo, vec3(1.0 - clear)), 1.0);
#else
  vec3 mirror = reflect(ray, n);
  vec3 sky = mirror.y > 0.0 ? 1.7 * backdrop(mirror) : FLOOR_COLOUR;
  vec3 sparkle = 6.0 * pow(max(dot(mirror, lamp), 0.0), 700.0) * LAMP_COLOUR;
  vec3 own = 0.5 * (1.0 - clear) * shade(albedo, metallic, roughness, world, n, n, ray);
  radiance = vec4(own + reflectance * sky + sparkle + emission, 1.0);
#endif
#else
  if (laid.colour.a < shine.a) discard;
  vec3 lit = shade(grained(albedo), metallic, roughness, world, n, laid.normal, ray);
  radiance = vec4(lit + emission, 1.0);
#endif
}
`;

export const FLOOR_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 viewProjection;
uniform mat4 floorMatrix;
out vec3 world;
void main() {
  world = (floorMatrix * vec4(position, 1.0)).xyz;
  gl_Position = viewProjection * vec4(world, 1.0);
}
`;

/** A half-space: a faint grid that dissolves into the haze. */
export const FLOOR_FRAGMENT = /* glsl */ `
${HEAD}
in vec3 world;
uniform vec3 floorNormal;
/** Distance of the camera from what it looks at [m]. */
uniform float distance0;
/** Width of the grid's squares, and the stage's origin within them [m]. */
uniform float spacing;
uniform vec3 gridOrigin;
${LAMP}${SKY}

void main() {
  float depth = length(world - eye);
  float far = depth / distance0;
  vec3 ray = (world - eye) / depth;
  vec2 cell = abs(fract((world + gridOrigin).xz / spacing + 0.5) - 0.5) * spacing;
  float pixel = max(1.1e-3 * depth, 1e-9);
  float line = clamp(1.5 - min(cell.x, cell.y) / pixel, 0.0, 1.0);
  vec3 albedo = FLOOR_COLOUR * (1.0 - 0.22 * line * exp(-0.25 * far * far));
  vec3 light = lampShare(world, floorNormal) * LAMP_COLOUR * max(dot(floorNormal, lamp), 0.0);
  vec3 lit = albedo * (light + skyLight(floorNormal));
  float haze = 1.0 - exp(-0.04 * far * far);
  radiance = vec4(mix(lit, HAZE_COLOUR, haze), 1.0);
}
`;

/** What is behind everything. */
export const BACKDROP_FRAGMENT = /* glsl */ `
${HEAD}
in vec2 screen;
uniform mat4 inverseViewProjection;
${SKY}
void main() {
  vec4 far = inverseViewProjection * vec4(screen, 1.0, 1.0);
  radiance = vec4(backdrop(normalize(far.xyz / far.w - eye)), 1.0);
}
`;
