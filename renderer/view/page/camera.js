// A camera on an orbit: azimuth and polar angle in degrees, distance and target in meters, as --orbit and --target;
// a roll in degrees; the height of the image in meters if it has no perspective, else null.
// SPDX-License-Identifier: Apache-2.0

const RADIANS = Math.PI / 180;
const POLE = 0.5; // degrees that the camera stays away from straight up and down

export function directions({ orbit: [theta, phi], roll = 0 }) {
  const st = Math.sin(theta * RADIANS), ct = Math.cos(theta * RADIANS);
  const sp = Math.sin(phi * RADIANS), cp = Math.cos(phi * RADIANS);
  const back = [sp * st, cp, sp * ct]; // from the target to the eye
  const level = [ct, 0, -st], upright = [-cp * st, sp, -cp * ct];
  const sr = Math.sin(roll * RADIANS), cr = Math.cos(roll * RADIANS);
  const right = level.map((x, i) => x * cr + upright[i] * sr), up = upright.map((x, i) => x * cr - level[i] * sr);
  return { back, right, up };
}

const along = (p, ...terms) => p.map((x, i) => terms.reduce((sum, [direction, t]) => sum + direction[i] * t, x));
const turned = ([theta, phi, radius], dTheta, dPhi) => [
  ((theta + dTheta + 540) % 360) - 180, Math.min(180 - POLE, Math.max(POLE, phi + dPhi)), radius];

export const eyeOf = (camera) => along(camera.target, [directions(camera).back, camera.orbit[2]]);

// Angles in degrees.
export const orbited = (camera, dTheta, dPhi) => ({ ...camera, orbit: turned(camera.orbit, dTheta, dPhi) });

// The eye stays, the target moves.
export function lookedAround(camera, dTheta, dPhi) {
  const next = orbited(camera, dTheta, dPhi);
  const { back } = directions(next);
  return { ...next, target: along(eyeOf(camera), [back, -camera.orbit[2]]) };
}

// Fractions of the image's height, at the distance of the target.
export function panned(camera, dx, dy) {
  const height = camera.orthographic ?? 2 * camera.orbit[2] * Math.tan(camera.fov * RADIANS / 2);
  const { right, up } = directions(camera);
  return { ...camera, target: along(camera.target, [right, -dx * height], [up, dy * height]) };
}

// A factor on the distance, or on the height of what is seen.
export function dollied(camera, factor) {
  const [theta, phi, radius] = camera.orbit;
  if (camera.orthographic) return { ...camera, orthographic: Math.min(1e8, Math.max(1e-4, camera.orthographic * factor)) };
  return { ...camera, orbit: [theta, phi, Math.min(1e8, Math.max(1e-4, radius * factor))] };
}

// Meters to the right, up and forward.
export function flown(camera, x, y, z) {
  const { back, right } = directions(camera);
  return { ...camera, target: along(camera.target, [right, x], [[0, 1, 0], y], [back, -z]) };
}

// The same direction and eye as far as possible, with the target at a point.
export function retargeted(camera, point) {
  const eye = eyeOf(camera);
  const d = eye.map((x, i) => x - point[i]);
  const radius = Math.hypot(...d);
  if (!(radius > 1e-6)) return camera;
  return { ...camera, target: point,
    orbit: turned([Math.atan2(d[0], d[2]) / RADIANS, Math.acos(Math.max(-1, Math.min(1, d[1] / radius))) / RADIANS, radius], 0, 0) };
}
