// SPDX-License-Identifier: Apache-2.0
#pragma once
// The seeds of each fuzzing target (targets.h).

#include "fuzz/targets.h"

namespace gnomon::fuzz {

std::vector<Bytes> png_seeds();
std::vector<Bytes> jpeg_seeds();
std::vector<Bytes> ppm_seeds();
std::vector<Bytes> exr_seeds();
std::vector<Bytes> hdr_seeds();
std::vector<Bytes> aff_seeds();
std::vector<Bytes> obj_seeds();
std::vector<Bytes> mtl_seeds();
std::vector<Bytes> gltf_seeds();
std::vector<Bytes> glb_seeds();
std::vector<Bytes> draco_seeds();
std::vector<Bytes> meshopt_seeds();
std::vector<Bytes> webp_seeds();
std::vector<Bytes> ply_seeds();
std::vector<Bytes> stl_seeds();
std::vector<Bytes> config_seeds();
std::vector<Bytes> option_seeds();
std::vector<Bytes> upload_seeds();

}   // namespace gnomon::fuzz
