// Hashes of texels that other decoders give for random blocks: output of ktx2/make_block_hashes.py.
// SPDX-License-Identifier: Apache-2.0
#include "tests/image/block_hashes.h"

namespace kindling::test {

const std::vector<BlockHash>& block_hashes() {
  static const std::vector<BlockHash> hashes = {
      {131, 2048, 0xac3f6df646315704},       {133, 2048, 0x9f4b5d5de1d4640d},
      {135, 2048, 0xbf1dd0340e156390},       {137, 2048, 0x0aa474a754004473},
      {139, 2048, 0xa4b73bbe5d99faa6},       {141, 2048, 0x621118597a970d38},
      {143, 2048, 0x99e70533c8599e69},       {144, 2048, 0x926fc48db4946420},
      {145, 2048, 0x4623e0f054510404},       {147, 2048, 0xb5fb92371b7da24a},
      {149, 2048, 0xd1ff2f571d8090b9},       {151, 2048, 0x4766a21f997cd22f},
      {153, 2048, 0x793c30bc3a0e0c5f},       {155, 2048, 0x5ea2551a38f1ac2a},
      {157, 75, 0xc1fdaed6643ac33e},         {158, 86, 0x5252e3d847ce3cc1},
      {159, 105, 0x5a993183b7e252c0},        {160, 105, 0xd3c408e72b105584},
      {161, 111, 0xf28839a757e6346e},        {162, 106, 0x07d452c44ada8688},
      {163, 118, 0x1ee5ab50228ec634},        {164, 132, 0x36f761ec1babb041},
      {165, 162, 0x7c3b1be6b6ce0591},        {166, 162, 0xaca06798f33828ab},
      {167, 140, 0x05b9627752508e25},        {168, 155, 0x520bbeeb5f9c4e09},
      {169, 199, 0x71c9d75d582b9338},        {170, 179, 0x5c678e1014b69452},
      {171, 211, 0xcacb63c8dafe3c5b},        {172, 225, 0x00dfe86b67660c0d},
      {173, 189, 0x90e53c254a70cc80},        {174, 160, 0xe83f7e8a1dbb9bd4},
      {175, 196, 0x3049c27216782d0d},        {176, 188, 0x264e081a1a949a14},
      {177, 240, 0x6988e953def595a1},        {178, 205, 0x1a85db0fb33aa2d2},
      {179, 226, 0x53b26b1da5c65ecd},        {180, 224, 0x236f1e5b8a9a14d8},
      {181, 244, 0xa012290a19e1d7c3},        {182, 273, 0x955525c9cc672ec2},
      {183, 290, 0xf6dc0b8e6ed4f08b},        {184, 243, 0x2f19cb0477b51938},
      {1000066000, 124, 0x3af6a546c614ab45}, {1000066001, 145, 0xc3b9117d43a64be6},
      {1000066002, 163, 0x944f1927718a7b24}, {1000066003, 228, 0x38ac5f6180590351},
      {1000066004, 256, 0x84bf36bc069bb47d}, {1000066005, 264, 0x42b72bdf3b64778f},
      {1000066006, 301, 0x489306187dcd0143}, {1000066007, 328, 0x8e1f6b4127388d46},
      {1000066008, 325, 0x2d2afb66d7e0134d}, {1000066009, 294, 0xb7a3db2f40b054a7},
      {1000066010, 351, 0x901107554b1b1a02}, {1000066011, 417, 0x93d4d5ffa939cb2d},
      {1000066012, 414, 0xfa09e0dfa65c0194}, {1000066013, 474, 0xb47da1b9a480ad82},
  };
  return hashes;
}

} // namespace kindling::test
