// Shaders of the scene: bodies, the height map and the ribbon of the path. Colours are written as they stand in the
// tables, without tone mapping, so that a colour in the picture can be read off the legend.
import * as THREE from "three";

export const shared = {
  clip: { value: new THREE.Vector4(0, 0, 0, 1) }, // dot(p, xyz) > w is cut away; xyz = 0: nothing is
  now: { value: 0 },
  viewport: { value: new THREE.Vector2(1, 1) },
};

const CLIP = `
uniform vec4 clip;
void cutAway(vec3 p) { if (dot(p, clip.xyz) > clip.w) discard; }
`;

// light from the camera's side and from above: edges read from any direction
const LIGHT = `
vec3 lit(vec3 base, vec3 n) {
  vec3 v = normalize(cameraPosition - place);
  if (dot(n, v) < 0.0) n = -n;
  vec3 s = normalize(cross(vec3(0.0, 0.0, 1.0), v) + vec3(1e-6, 0.0, 0.0));
  vec3 key = normalize(v + 0.75 * s + vec3(0.0, 0.0, 0.65));
  float d = max(dot(n, key), 0.0);
  float sky = 0.5 + 0.5 * n.z;
  return base * (0.56 + 0.32 * d + 0.20 * sky);
}
`;

const TABLE = `
uniform sampler2D tableOf;
uniform float low;
uniform float high;
vec3 coloured(float value) {
  float k = high > low ? clamp(floor(256.0 * (value - low) / (high - low)), 0.0, 255.0) : 128.0;
  return texelFetch(tableOf, ivec2(int(k), 0), 0).rgb;
}
`;

export function tableTexture(table: Uint8Array): THREE.DataTexture {
  const rgba = new Uint8Array(1024);
  for (let i = 0; i < 256; i++) rgba.set([table[3 * i], table[3 * i + 1], table[3 * i + 2], 255], 4 * i);
  const texture = new THREE.DataTexture(rgba, 256, 1, THREE.RGBAFormat, THREE.UnsignedByteType);
  texture.needsUpdate = true;
  return texture;
}

export interface BodyOptions {
  tint: THREE.ColorRepresentation;
  opacity?: number;
  table?: THREE.DataTexture;
  low?: number;
  high?: number;
  smooth?: boolean;
}

export function bodyMaterial(options: BodyOptions): THREE.ShaderMaterial {
  const coloured = options.table !== undefined;
  const opacity = options.opacity ?? 1;
  return new THREE.ShaderMaterial({
    uniforms: {
      clip: shared.clip,
      tint: { value: new THREE.Color().setStyle(new THREE.Color(options.tint).getStyle(THREE.SRGBColorSpace), THREE.LinearSRGBColorSpace) },
      opacity: { value: opacity },
      tableOf: { value: options.table ?? null },
      low: { value: options.low ?? 0 },
      high: { value: options.high ?? 1 },
    },
    defines: { ...(coloured ? { COLOURED: 1 } : {}), ...(options.smooth ? { SMOOTH: 1 } : {}) },
    vertexShader: `
      ${coloured ? "attribute float value; varying float shown;" : ""}
      varying vec3 place; varying vec3 turned;
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0);
        place = world.xyz;
        #ifdef SMOOTH
        turned = mat3(modelMatrix) * normal;
        #endif
        ${coloured ? "shown = value;" : ""}
        gl_Position = projectionMatrix * viewMatrix * world;
      }`,
    fragmentShader: `
      precision highp float;
      varying vec3 place; varying vec3 turned;
      ${coloured ? "varying float shown;" : ""}
      uniform vec3 tint; uniform float opacity;
      ${CLIP} ${coloured ? TABLE : ""} ${LIGHT}
      void main() {
        cutAway(place);
        #ifdef SMOOTH
        vec3 n = normalize(turned);
        #else
        vec3 n = normalize(cross(dFdx(place), dFdy(place)));
        #endif
        vec3 base = tint;
        ${coloured ? "if (shown == shown && shown > -1e30) base = coloured(shown);" : ""}
        gl_FragColor = vec4(lit(base, n), opacity);
      }`,
    side: THREE.DoubleSide,
    polygonOffset: opacity < 1,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    transparent: opacity < 1,
    depthWrite: opacity >= 1,
  });
}

export interface MapUniforms {
  heights: THREE.DataTexture;
  values: THREE.DataTexture | null;
  table: THREE.DataTexture | null;
  low: number;
  high: number;
}

export function mapMaterial(given: MapUniforms, uniforms: Record<string, THREE.IUniform>): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: {
      ...uniforms,
      clip: shared.clip,
      heights: { value: given.heights },
      values: { value: given.values },
      tableOf: { value: given.table },
      low: { value: given.low },
      high: { value: given.high },
    },
    defines: given.values ? { COLOURED: 1 } : {},
    vertexShader: `
      precision highp usampler2D;
      uniform usampler2D heights;
      uniform vec2 corner; uniform vec2 cell; uniform ivec2 first; uniform ivec2 size; uniform int side;
      uniform float zero; uniform float scale; uniform float top; uniform bool before;
      out vec3 place; out vec2 grid; flat out int gone;
      void main() {
        ivec2 k = min(first + ivec2(gl_VertexID % side, gl_VertexID / side), size - 1);
        uint q = texelFetch(heights, k, 0).r;
        gone = q == 65535u && !before ? 1 : 0;
        float z = before || q == 65535u ? top : zero + scale * float(q);
        grid = vec2(k);
        vec4 world = modelMatrix * vec4(corner + (vec2(k) + 0.5) * cell, z, 1.0);
        place = world.xyz;
        gl_Position = projectionMatrix * viewMatrix * world;
      }`,
    fragmentShader: `
      precision highp float; precision highp usampler2D;
      in vec3 place; in vec2 grid; flat in int gone;
      out vec4 colour;
      uniform usampler2D heights;
      uniform ivec2 size; uniform float top; uniform bool before; uniform float zero; uniform float scale;
      uniform vec3 uncut; uniform vec3 cut;
      #ifdef COLOURED
      uniform usampler2D values; uniform float valueZero; uniform float valueScale;
      ${TABLE}
      #endif
      ${CLIP} ${LIGHT}
      void main() {
        cutAway(place);
        if (gone == 1) discard;
        vec3 n = normalize(cross(dFdx(place), dFdy(place)));
        bool untouched = before || place.z > top - 1e-3 * max(1.0, abs(top));
        vec3 base = untouched ? uncut : cut;
        #ifdef COLOURED
        if (!before) {
          ivec2 k = clamp(ivec2(floor(grid)), ivec2(0), size - 2);
          float best = 0.0; bool found = false;
          for (int j = 0; j < 2; j++) for (int i = 0; i < 2; i++) {
            uint q = texelFetch(values, k + ivec2(i, j), 0).r;
            if (q != 65535u) {
              float v = valueZero + valueScale * float(q);
              if (!found || abs(v) > abs(best)) { best = v; found = true; }
            }
          }
          if (found && !untouched) base = coloured(best);
        }
        #endif
        colour = vec4(lit(base, n), 1.0);
      }`,
    side: THREE.DoubleSide,
  });
}

export function ribbonMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: { clip: shared.clip, now: shared.now, viewport: shared.viewport, width: { value: 2.5 }, casing: { value: 1.0 } },
    vertexShader: `
      in vec3 from; in vec3 to; in vec4 colour; in float kind;
      uniform vec2 viewport; uniform float width; uniform float casing;
      out vec3 shown; out float across; out float dashed; out float along; out float number; out vec3 place;
      void main() {
        if (kind > 2.5) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
        vec4 a = projectionMatrix * viewMatrix * vec4(from, 1.0);
        vec4 b = projectionMatrix * viewMatrix * vec4(to, 1.0);
        float near = 1e-4;
        if (a.w < near && b.w > near) a = mix(b, a, (b.w - near) / (b.w - a.w));
        if (b.w < near && a.w > near) b = mix(a, b, (a.w - near) / (a.w - b.w));
        vec2 sa = a.xy / a.w * viewport * 0.5;
        vec2 sb = b.xy / b.w * viewport * 0.5;
        vec2 d = sb - sa;
        float len = length(d);
        vec2 u = len > 1e-6 ? d / len : vec2(1.0, 0.0);
        vec2 v = vec2(-u.y, u.x);
        bool rapid = kind < 0.5;
        bool thin = rapid || colour.a < 0.5;
        float half_ = 0.5 * (thin ? max(1.0, 0.5 * width) : width + 2.0 * casing);
        vec4 p = position.x < 0.5 ? a : b;
        vec2 off = position.y * half_ * v + (position.x < 0.5 ? -1.0 : 1.0) * min(half_, 0.5) * u;
        across = position.y * half_;
        along = position.x * len;
        dashed = rapid ? 1.0 : 0.0;
        shown = colour.a < 0.5 ? vec3(-1.0) : colour.rgb; number = float(gl_InstanceID); place = position.x < 0.5 ? from : to;
        p.xy += off / (viewport * 0.5) * p.w;
        p.z -= 3e-5 * p.w;
        gl_Position = p;
      }`,
    fragmentShader: `
      precision highp float;
      in vec3 shown; in float across; in float dashed; in float along; in float number; in vec3 place;
      uniform float now; uniform float width;
      out vec4 colour;
      ${CLIP}
      void main() {
        cutAway(place);
        float opacity = number > now ? 0.25 : 1.0;
        if (dashed > 0.5) {
          if (mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) > 4.5) discard;
          colour = vec4(vec3(0.5), 0.8 * opacity);
          return;
        }
        if (shown.r < 0.0) {
          colour = vec4(vec3(0.45), 0.7 * opacity);
          return;
        }
        bool core = abs(across) <= 0.5 * width;
        colour = vec4(core ? shown : vec3(0.09, 0.11, 0.14), opacity);
      }`,
    transparent: true,
    side: THREE.DoubleSide,
  });
}
