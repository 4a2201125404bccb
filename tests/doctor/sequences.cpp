// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "doctor/sequences.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

ExrImage ImageOf(const Frame& frame) {
  ExrImage image;
  image.width = frame.width;
  image.height = frame.height;
  image.attributes["jitter"] =
      std::to_string(frame.jitter_x) + " " + std::to_string(frame.jitter_y);
  const Guides& g = frame.guides;
  image.Add("", PixelType::kHalf, SumOfLight(frame));
  for (const Signal& signal : frame.signals) {
    image.Add(std::string(SignalName(signal.kind)) + ".", PixelType::kHalf, signal.radiance);
  }
  image.Add("motion.X", PixelType::kFloat, g.motion[0]);
  image.Add("motion.Y", PixelType::kFloat, g.motion[1]);
  image.Add("depth.Z", PixelType::kFloat, g.depth);
  image.Add("normal.", PixelType::kHalf, g.normal, true);
  image.Add("albedo.", PixelType::kHalf, g.albedo);
  image.Add("specular_albedo.", PixelType::kHalf, g.specular_albedo);
  image.Add("id.X", g.id);
  const VirtualGuides& r = frame.reflection;
  if (!r.empty()) {
    image.Add("reflection_depth.Z", PixelType::kFloat, r.depth);
    image.Add("reflection_normal.", PixelType::kHalf, r.normal, true);
    image.Add("reflection_albedo.", PixelType::kHalf, r.albedo);
    image.Add("reflection_motion.X", PixelType::kFloat, r.motion[0]);
    image.Add("reflection_motion.Y", PixelType::kFloat, r.motion[1]);
    image.Add("reflection_id.X", r.id);
  }
  image.Add("emission.", PixelType::kHalf, frame.emission);
  image.Add("background.", PixelType::kHalf, frame.background);
  return image;
}

void AddScaled(const Image3& from, float scale, Image3* to) {
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < from.height(); ++y) {
      for (int x = 0; x < from.width(); ++x) {
        (*to)[c](x, y) += scale * from[c](x, y);
      }
    }
  }
}

void Clear(Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c].Fill(0);
  }
}

/// \param centred  a renderer without jitter
Frame Averaged(Renderer* jittered, Renderer* centred, RenderMoment moment) {
  constexpr int kSamples = 4;
  Frame mean;
  EXPECT_TRUE(centred->RenderFrame(moment, &mean).ok());
  for (Image3* image : {&mean.guides.albedo, &mean.guides.specular_albedo, &mean.guides.normal,
                        &mean.emission, &mean.background}) {
    Clear(image);
  }
  for (Signal& signal : mean.signals) {
    Clear(&signal.radiance);
  }
  const int64_t first = moment.frame_index * kSamples;
  for (int i = 0; i < kSamples; ++i) {
    moment.frame_index = first + i;
    Frame one;
    EXPECT_TRUE(jittered->RenderFrame(moment, &one).ok());
    AddScaled(one.guides.albedo, 1.0f / kSamples, &mean.guides.albedo);
    AddScaled(one.guides.specular_albedo, 1.0f / kSamples, &mean.guides.specular_albedo);
    AddScaled(one.guides.normal, 1.0f / kSamples, &mean.guides.normal);
    AddScaled(one.emission, 1.0f / kSamples, &mean.emission);
    AddScaled(one.background, 1.0f / kSamples, &mean.background);
    for (size_t s = 0; s < mean.signals.size(); ++s) {
      AddScaled(one.signals[s].radiance, 1.0f / kSamples, &mean.signals[s].radiance);
    }
  }
  return mean;
}

}  // namespace

namespace {

Sequence Rendered(const SceneOptions& o) {
  Sequence sequence;
  const Result<Scene> scene = MakeBuiltinScene(o.scene);
  EXPECT_TRUE(scene.ok()) << scene.status().message();
  RenderSettings settings;
  settings.width = o.width;
  settings.height = o.height;
  settings.spp = o.spp;
  settings.jitter = o.jitter;
  settings.virtual_guides = o.virtual_guides;
  const auto renderer = Renderer::Create(*scene, settings);
  EXPECT_TRUE(renderer.ok()) << renderer.status().message();
  std::unique_ptr<Renderer> centred;
  if (o.averaged) {
    settings.jitter = false;
    Result<std::unique_ptr<Renderer>> made = Renderer::Create(*scene, settings);
    EXPECT_TRUE(made.ok()) << made.status().message();
    centred = std::move(made.value());
  }
  for (int i = 0; i < o.frames; ++i) {
    RenderMoment moment;
    moment.frame_index = o.fixed_seed ? 0 : i;
    moment.seconds = o.start + i * o.step;
    moment.previous_seconds = i == 0 ? moment.seconds : moment.seconds - o.step;
    Frame frame;
    if (o.averaged) {
      frame = Averaged(renderer->get(), centred.get(), moment);
    } else {
      const Status status = renderer.value()->RenderFrame(moment, &frame);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    sequence.push_back({i + 1, ImageOf(frame)});
  }
  return sequence;
}

}  // namespace

Sequence RenderSequence(const SceneOptions& options) {
  // Most tests spoil frames of the same few sequences.
  static std::vector<std::pair<SceneOptions, Sequence>> rendered;
  for (const auto& [of, sequence] : rendered) {
    if (of == options) {
      return sequence;
    }
  }
  return rendered.emplace_back(options, Rendered(options)).second;
}

DoctorReport ReportOf(const Sequence& sequence, const AovOptions& options) {
  const std::unique_ptr<Doctor> doctor = Doctor::Create(options);
  for (const NumberedImage& frame : sequence) {
    const Status status =
        doctor->Add(frame.number, "frame " + std::to_string(frame.number), frame.image);
    EXPECT_TRUE(status.ok()) << status.message();
  }
  Result<DoctorReport> report = doctor->Report();
  EXPECT_TRUE(report.ok()) << report.status().message();
  for (const Finding& f : report->findings) {
    // One line each, and something to do about it.
    EXPECT_EQ(f.what.find('\n'), std::string::npos);
    EXPECT_FALSE(f.what.empty());
    EXPECT_FALSE(f.cure.empty()) << f.name;
    EXPECT_FALSE(f.frames.empty()) << f.name;
    const auto table = FindingTable();
    EXPECT_TRUE(std::any_of(table.begin(), table.end(), [&](const FindingInfo& info) {
      return info.name == f.name;
    })) << f.name;
  }
  return std::move(report.value());
}

std::set<std::string> FindingsOf(const Sequence& sequence, const AovOptions& options) {
  std::set<std::string> names;
  const DoctorReport report = ReportOf(sequence, options);
  if (std::getenv("STILLRAY_MEASURES") != nullptr) {
    for (const Measure& m : report.measures) {
      std::printf("%s=%.3g(%.3g) ", m.name.c_str(), m.value, m.limit);
    }
    std::printf("\n");
  }
  for (const Finding& f : report.findings) {
    names.insert(f.name);
    std::printf("%s: %s\n  cure: %s\n", f.name.c_str(), f.what.c_str(), f.cure.c_str());
  }
  return names;
}

Channel& ChannelOf(ExrImage& image, const std::string& name) {
  for (Channel& channel : image.channels) {
    if (channel.name == name) {
      return channel;
    }
  }
  ADD_FAILURE() << "no channel " << name;
  return image.channels.front();
}

namespace {

void ChangeValues(Channel* channel, const Change& change) {
  for (int y = 0; y < channel->values.height(); ++y) {
    for (int x = 0; x < channel->values.width(); ++x) {
      channel->values(x, y) = change(channel->values(x, y), x, y);
    }
  }
}

}  // namespace

void ChangeChannel(Sequence* sequence, const std::string& name, const Change& change) {
  for (NumberedImage& frame : *sequence) {
    ChangeValues(&ChannelOf(frame.image, name), change);
  }
}

void ChangeLayer(Sequence* sequence, const std::string& prefix, const Change& change) {
  for (NumberedImage& frame : *sequence) {
    for (Channel& channel : frame.image.channels) {
      if (channel.name.starts_with(prefix)) {
        ChangeValues(&channel, change);
      }
    }
  }
}

void SwapChannels(Sequence* sequence, const std::string& a, const std::string& b) {
  for (NumberedImage& frame : *sequence) {
    std::swap(ChannelOf(frame.image, a).values, ChannelOf(frame.image, b).values);
  }
}

void RemoveLayer(Sequence* sequence, const std::string& prefix) {
  for (NumberedImage& frame : *sequence) {
    std::erase_if(frame.image.channels,
                  [&](const Channel& c) { return c.name.starts_with(prefix); });
  }
}

float NoiseAt(int x, int y, int64_t frame, int channel) {
  const uint32_t bits =
      HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)),
                  HashCombine(static_cast<uint32_t>(frame), static_cast<uint32_t>(channel)));
  return 2 * UniformFloat(bits) - 1;
}

}  // namespace stillray
