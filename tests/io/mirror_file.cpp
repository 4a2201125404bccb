// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/mirror_file.h"

#include <vector>

namespace stillray {
namespace {

void AddLight(const std::string& kind, const Image3& colour, ExrImage* image) {
  const Image3 light = White(image->width, image->height);
  image->Add("V." + kind + "Dir.", PixelType::kHalf, light);
  image->Add("V." + kind + "Ind.", PixelType::kHalf, light);
  image->Add("V." + kind + "Col.", PixelType::kHalf, colour);
}

}  // namespace

Image3 White(int width, int height) {
  Image3 image(width, height);
  for (int c = 0; c < 3; ++c) {
    image[c].Fill(1);
  }
  return image;
}

ExrImage FileOf(const RoomPicture& picture, const std::string& without) {
  const Guides& g = picture.frame.guides;
  ExrImage image;
  image.width = picture.frame.width;
  image.height = picture.frame.height;
  AddLight("Diff", g.albedo, &image);
  AddLight("Gloss", g.specular_albedo, &image);
  AddLight("Trans", g.transmission_albedo, &image);
  image.Add("V.Combined.", PixelType::kHalf, White(image.width, image.height));
  image.Add("V.Depth.Z", PixelType::kFloat, g.depth);
  image.Add("V.Normal.", PixelType::kFloat, g.normal, true);
  Image1 up = g.motion[1];
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      up(x, y) = -up(x, y);
    }
  }
  image.Add("V.Vector.X", PixelType::kFloat, g.motion[0]);
  image.Add("V.Vector.Y", PixelType::kFloat, up);
  image.Add("V.Denoising Depth.Z", PixelType::kFloat, picture.seen.depth);
  image.Add("V.Denoising Normal.", PixelType::kFloat, picture.seen.normal, true);
  image.Add("V.Denoising Albedo.", PixelType::kHalf, picture.seen.albedo);
  std::erase_if(image.channels,
                [&](const Channel& channel) { return channel.name.starts_with("V." + without); });
  return image;
}

}  // namespace stillray
