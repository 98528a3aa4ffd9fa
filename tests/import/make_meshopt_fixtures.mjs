// Writes meshopt_fixtures_tables.cpp: streams of attribute codec version 1 from meshoptimizer's encoder, and their
// bytes from its reference decoder in JavaScript (the WebAssembly one of 1.0.1 decodes rotated XOR deltas wrongly under Node 20).
// Usage: npm install meshoptimizer@1.0.1; node make_meshopt_fixtures.mjs > meshopt_fixtures_tables.cpp
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert';
import {MeshoptEncoder} from 'meshoptimizer';
import {MeshoptDecoder} from './node_modules/meshoptimizer/meshopt_decoder_reference.js';
await MeshoptEncoder.ready;

let state = 1;
const random = () => (state = Math.imul(state, 1664525) + 1013904223 >>> 0) / 2 ** 32;
const floats = (n, f) => new Uint8Array(Float32Array.from({length: n}, (_, i) => f(i)).buffer);
const shorts = (n, f) => new Uint8Array(Uint16Array.from({length: n}, (_, i) => f(i)).buffer);
const bytes = (n, f) => Uint8Array.from({length: n}, (_, i) => f(i));

const fixtures = [];
const add = (name, source, count, stride, filter = 'NONE') => {
  const encoded = MeshoptEncoder.encodeVertexBufferLevel(source, count, stride, 3, 1);
  const decoded = new Uint8Array(count * stride);
  MeshoptDecoder.decodeGltfBuffer(decoded, count, stride, encoded, 'ATTRIBUTES', filter);
  if (filter === 'NONE') assert.deepEqual(decoded, source);
  fixtures.push({name, filter, count, stride, encoded, decoded});
};
add('one element', bytes(4, i => 10 * i), 1, 4);
add('bytes that move slowly', bytes(4 * 21, i => (i >> 2) * (i & 3)), 21, 4);
add('random bytes beside constant ones', bytes(8 * 37, i => i % 8 < 4 ? 256 * random() : 7), 37, 8);
add('single bits', bytes(4 * 48, i => random() < 0.2 ? 1 : 0), 48, 4);
add('rare large steps', bytes(4 * 64, i => random() < 0.1 ? 256 * random() : i >> 4), 64, 4);
add('smooth 16-bit numbers', shorts(4 * 50, i => 30000 + 20000 * Math.sin(0.02 * (i >> 2) + (i & 3))), 50, 8);
add('floats', floats(3 * 50, i => Math.sin(0.3 * i) + 2), 50, 12);
add('floats of whole numbers', floats(2 * 33, i => 3 * (i >> 1) * (1 + (i & 1))), 33, 8);
add('two blocks', bytes(4 * 300, i => (i >> 2) * (i & 1) / 5), 300, 4);
add('blocks of 16 elements', bytes(256 * 20, i => (i >> 8) + (i & 3)), 20, 256);
const colors = Float32Array.from({length: 4 * 18}, (_, i) => i % 4 == 3 ? 1 - (i >> 2) / 17 : random());
add('colors of 8 bits', MeshoptEncoder.encodeFilterColor(colors, 18, 4, 8), 18, 4, 'COLOR');
add('colors of 6 of 8 bits', MeshoptEncoder.encodeFilterColor(colors, 18, 4, 6), 18, 4, 'COLOR');
add('colors of 16 bits', MeshoptEncoder.encodeFilterColor(colors, 18, 8, 16), 18, 8, 'COLOR');
add('colors of 11 of 16 bits', MeshoptEncoder.encodeFilterColor(colors, 18, 8, 11), 18, 8, 'COLOR');

const text = data => {
  const base64 = Buffer.from(data).toString('base64');
  return (base64.match(/.{1,110}/g) ?? ['']).map(line => `\n     "${line}"`).join('');
};
console.log(`// Streams of meshoptimizer 1.0.1 with their decoded bytes; written by make_meshopt_fixtures.mjs.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/meshopt_fixtures.h"

namespace kindling::test {
namespace {

// clang-format off
constexpr MeshoptFixture kFixtures[] = {`);
for (const f of fixtures)
  console.log(`    {"${f.name}", "${f.filter}", ${f.count}, ${f.stride},${text(f.encoded)},${text(f.decoded)}},`);
console.log(`};
// clang-format on

} // namespace

std::span<const MeshoptFixture> meshopt_fixtures() { return kFixtures; }

} // namespace kindling::test`);
const used = new Set();
for (const f of fixtures) {
  const modes = f.encoded.slice(f.encoded.length - f.stride / 4);
  for (const m of modes) used.add(m);
}
console.error('channel modes:', [...used].map(m => '0x' + m.toString(16)).join(' '));
