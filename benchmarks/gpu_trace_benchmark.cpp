// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rays per second on a Vulkan device, by both tracing methods, compared with Embree on the CPU:
//
//   gpu_trace_benchmark                                   the built-in scenes, any Vulkan device
//   gpu_trace_benchmark --device vulkan:0 --size 1920x1080 --repeats 20 kitchen.glb
//
// Primary rays, rays in random directions from the primary hits, and shadow rays from the primary
// hits to points of the scene (identical for all methods, in image order); then milliseconds of
// complete frames with one path per pixel, including shading. If the device has ray tracing
// hardware, both tracing methods are measured alternately, and frames with rasterised and with
// traced primary hits. The minimum over the repeats counts: on the device the time of the dispatch
// or frame alone, by timestamps; for Embree the time of tracing, on all threads.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "render/camera.h"
#include "render/geometry_shared.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/gpu_batch.h"
#include "stillray/scene.h"

namespace stillray::render {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> scenes;
  std::string device = "vulkan";
  std::string size = "1280x720";
  std::string json_path;
  int width = 0;
  int height = 0;
  int repeats = 5;
};

std::vector<GpuRay> CameraRays(const SceneState& state, const Options& options) {
  const Camera& camera = state.scene().cameras[0];
  const CameraView view = MakeCameraView(camera, state.nodes()[static_cast<size_t>(camera.node)],
                                         options.width, options.height);
  std::vector<GpuRay> rays;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      rays.push_back({view.position, std::numeric_limits<float>::infinity(),
                      view.Direction(vec2(x, y) + vec2(0.5f)), 0});
    }
  }
  return rays;
}

std::vector<GpuRay> BounceRays(const SceneState& state, const std::vector<GpuRay>& rays,
                               const std::vector<GpuHit>& hits) {
  std::vector<GpuRay> out;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].instance == kNoInstance) {
      continue;
    }
    const Triangle t = state.TriangleOf(state.instance(hits[i].instance), hits[i].primitive);
    vec3 normal = SafeNormalize(cross(t.p1 - t.p0, t.p2 - t.p0), rays[i].direction);
    normal = dot(normal, rays[i].direction) > 0 ? -normal : normal;
    vec3 direction = RandomDirection(static_cast<uint32_t>(i));
    direction = dot(direction, normal) < 0 ? -direction : direction;
    const vec3 point = rays[i].origin + rays[i].direction * hits[i].t;
    out.push_back({OffsetPoint(point, normal), rays[i].end, direction, 0});
  }
  return out;
}

/// Shadow rays from the origins of `rays` to points in the bounding box of the scene.
std::vector<GpuRay> ShadowRays(const Scene& scene, std::vector<GpuRay> rays) {
  const Aabb box = SceneBounds(scene, 0);
  for (size_t i = 0; i < rays.size(); ++i) {
    const auto h = static_cast<uint32_t>(3 * i);
    const vec3 u(UniformFloat(HashU32(h)), UniformFloat(HashU32(h + 1)),
                 UniformFloat(HashU32(h + 2)));
    const vec3 way = box.min + (box.max - box.min) * u - rays[i].origin;
    rays[i].direction = SafeNormalize(way, rays[i].direction);
    rays[i].end = glm::length(way);
  }
  return rays;
}

double EmbreeMilliseconds(const Accel& accel, const std::vector<GpuRay>& rays, bool shadow) {
  const size_t batches = (rays.size() + kBatchCapacity - 1) / kBatchCapacity;
  std::vector<RayBatch> loaded(batches);
  ForBatches(rays,
             [&](const RayBatch& batch, size_t first) { loaded[first / kBatchCapacity] = batch; });
  const auto start = std::chrono::steady_clock::now();
  tbb::parallel_for(size_t{0}, batches, [&](size_t i) {
    thread_local const auto hits = std::make_unique<HitBatch>();
    thread_local std::vector<vec3> lights(kBatchCapacity);
    if (shadow) {
      accel.Occluded(loaded[i], lights.data());
    } else {
      accel.IntersectIncoherent(loaded[i], hits.get());
    }
  });
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  return time.count();
}

/// A tracing method, and its last measurement.
struct Way {
  const char* name;
  TracingWay way;
  std::unique_ptr<GpuAccel> accel;
  std::unique_ptr<GpuBatch> batch;
  double least_ms = 1e30;
};

/// Complete frames by one tracing method, with rasterised or traced primary hits.
struct FrameWay {
  std::string name;
  std::string first_hits;
  std::unique_ptr<Renderer> renderer;
  double least_ms = 1e30;
  RenderTimings best;
};

/// \param shadow  trace shadow rays instead of first hits
Status Measure(const char* kind, const std::vector<GpuRay>& rays, bool shadow, const Accel& embree,
               const Options& options, std::vector<Way>* ways, Json* json) {
  double embree_ms = 1e30;
  for (Way& way : *ways) {
    way.least_ms = 1e30;
  }
  for (int i = 0; i < options.repeats; ++i) {
    for (Way& way : *ways) {
      if (shadow) {
        way.batch->Transmittance(rays);
      } else {
        way.batch->FirstHits(rays);
      }
      STILLRAY_RETURN_IF_ERROR(way.batch->status());
      way.least_ms = std::min(way.least_ms, way.batch->milliseconds());
    }
    embree_ms = std::min(embree_ms, EmbreeMilliseconds(embree, rays, shadow));
  }
  const auto rate = [&](double ms) { return static_cast<double>(rays.size()) / ms * 1e-3; };
  std::printf("  %-8s %9zu rays", kind, rays.size());
  for (const Way& way : *ways) {
    std::printf("   %s %9.2f M/s", way.name, rate(way.least_ms));
  }
  std::printf("   Embree %9.2f M/s\n", rate(embree_ms));
  Json& rates = (*json)["million_rays_per_second"][kind];
  rates["rays"] = rays.size();
  for (const Way& way : *ways) {
    rates[way.name] = rate(way.least_ms);
  }
  rates["embree"] = rate(embree_ms);
  return Status::Ok();
}

Result<std::vector<FrameWay>> MakeFrameWays(const std::shared_ptr<gpu::Device>& device,
                                            const Scene& scene, const Options& options,
                                            const std::vector<Way>& ways) {
  std::vector<FrameWay> made;
  for (const Way& way : ways) {
    for (const bool draw : {true, false}) {
      if (draw && !device->can_draw()) {
        continue;
      }
      RenderSettings settings;
      settings.width = options.width;
      settings.height = options.height;
      Result<std::unique_ptr<Renderer>> renderer = CreateVulkanRenderer(
          scene, settings, device,
          {.first_hits = draw ? FirstHits::kDraw : FirstHits::kTrace, .way = way.way});
      STILLRAY_RETURN_IF_ERROR(renderer.status());
      made.push_back({way.name, draw ? "drawn" : "traced", std::move(*renderer), 1e30, {}});
    }
  }
  return made;
}

/// Complete frames: guides, paths and shading, measured by device timestamps.
Status MeasureFrames(const Options& options, std::vector<FrameWay>* ways, Json* json) {
  for (int i = 0; i < options.repeats; ++i) {
    for (FrameWay& way : *ways) {
      Frame frame;
      RenderMoment moment;
      moment.frame_index = i;
      STILLRAY_RETURN_IF_ERROR(way.renderer->RenderFrame(moment, &frame));
      const RenderTimings& t = way.renderer->timings();
      const double ms = t.primary_ms + t.shade_ms + t.shadow_ms + t.bounce_ms;
      if (ms < way.least_ms) {
        way.least_ms = ms;
        way.best = t;
      }
    }
  }
  for (const FrameWay& way : *ways) {
    const RenderTimings& t = way.best;
    std::printf(
        "  frame    %-8s %9.2f ms: camera's rays (%s) and guides %.2f, shading %.2f, shadow rays "
        "%.2f, bounce rays %.2f\n",
        way.name.c_str(), way.least_ms, way.first_hits.c_str(), t.primary_ms, t.shade_ms,
        t.shadow_ms, t.bounce_ms);
    (*json)["frames"].push_back({{"way", way.name},
                                 {"first_hits", way.first_hits},
                                 {"ms", way.least_ms},
                                 {"primary_ms", t.primary_ms},
                                 {"shade_ms", t.shade_ms},
                                 {"shadow_ms", t.shadow_ms},
                                 {"bounce_ms", t.bounce_ms}});
  }
  return Status::Ok();
}

Status MakeWay(const std::shared_ptr<gpu::Device>& device, const SceneState& state,
               const Options& options, Way* way) {
  const auto start = std::chrono::steady_clock::now();
  Result<std::unique_ptr<GpuAccel>> accel = GpuAccel::Create(device.get(), state, way->way);
  STILLRAY_RETURN_IF_ERROR(accel.status());
  way->accel = std::move(*accel);
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  const gpu::MemoryUse memory = way->accel->memory();
  std::printf("  %-8s built in %.0f ms, %.1f MiB on the device, largest %.1f MiB\n", way->name,
              time.count(), static_cast<double>(memory.bytes) * 0x1p-20,
              static_cast<double>(memory.largest) * 0x1p-20);
  const auto most = static_cast<uint32_t>(options.width * options.height);
  way->batch = std::make_unique<GpuBatch>(device.get(), way->accel.get(), most);
  return way->batch->status();
}

Status RunScene(const std::shared_ptr<gpu::Device>& device, const std::string& spec,
                const Options& options, Json* list) {
  const Result<Scene> scene = LoadScene(spec);
  if (!scene.ok()) {
    return scene.status();
  }
  SceneState state(*scene);
  state.Update(0, 0);
  const SceneShadowFilter filter(state);
  const auto embree = Accel::Create(*scene, DescribeInstances(state), state.Places(), filter);
  if (!embree.ok()) {
    return embree.status();
  }
  std::printf("%s: %zu triangles\n", spec.c_str(), scene->TriangleCount());
  Json json = {{"scene", spec}, {"triangles", scene->TriangleCount()}};
  std::vector<Way> ways;
  ways.push_back({"compute", TracingWay::kCompute, {}, {}});
  if (device->context().ray_tracing.offered) {
    ways.push_back({"hardware", TracingWay::kHardware, {}, {}});
  }
  for (Way& way : ways) {
    STILLRAY_RETURN_IF_ERROR(MakeWay(device, state, options, &way));
  }
  const std::vector<GpuRay> camera = CameraRays(state, options);
  const std::vector<GpuRay> bounce = BounceRays(state, camera, ways[0].batch->FirstHits(camera));
  STILLRAY_RETURN_IF_ERROR(Measure("camera", camera, false, **embree, options, &ways, &json));
  STILLRAY_RETURN_IF_ERROR(Measure("bounce", bounce, false, **embree, options, &ways, &json));
  STILLRAY_RETURN_IF_ERROR(
      Measure("shadow", ShadowRays(*scene, bounce), true, **embree, options, &ways, &json));
  Result<std::vector<FrameWay>> frames = MakeFrameWays(device, *scene, options, ways);
  STILLRAY_RETURN_IF_ERROR(frames.status());
  STILLRAY_RETURN_IF_ERROR(MeasureFrames(options, &*frames, &json));
  list->push_back(std::move(json));
  return Status::Ok();
}

Status WriteJson(const Options& options, const gpu::DeviceInfo& device, const Json& scenes) {
  if (options.json_path.empty()) {
    return Status::Ok();
  }
  std::ofstream file(options.json_path);
  file << Json{{"device", device.name},
               {"width", options.width},
               {"height", options.height},
               {"repeats", options.repeats},
               {"scenes", scenes}}
              .dump(2)
       << "\n";
  file.close();
  return file ? Status::Ok() : Status::Io(options.json_path + ": cannot be written");
}

Status Run(Options options) {
  if (std::sscanf(options.size.c_str(), "%dx%d", &options.width, &options.height) != 2 ||
      options.width < 1 || options.height < 1 || options.width > 16384 || options.height > 16384) {
    return Status::InvalidArgument("--size is " + options.size + ", expected WIDTHxHEIGHT");
  }
  if (options.scenes.empty()) {
    for (const std::string& name : BuiltinSceneNames()) {
      options.scenes.push_back("builtin:" + name);
    }
  }
  const Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create();
  if (!instance.ok()) {
    return instance.status();
  }
  const Result<std::vector<gpu::DeviceInfo>> devices = (*instance)->ListDevices();
  if (!devices.ok()) {
    return devices.status();
  }
  const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(*devices, options.device);
  if (!chosen.ok()) {
    return chosen.status();
  }
  const Result<std::shared_ptr<gpu::Device>> device = gpu::Device::Create(*instance, *chosen);
  if (!device.ok()) {
    return device.status();
  }
  if (!(*device)->has_timestamps()) {
    return Status::Unsupported(chosen->name + " measures no times");
  }
  std::printf("%s, %dx%d, least of %d\n", chosen->name.c_str(), options.width, options.height,
              options.repeats);
  Json scenes = Json::array();
  for (const std::string& scene : options.scenes) {
    STILLRAY_RETURN_IF_ERROR(RunScene(*device, scene, options, &scenes));
    std::fflush(stdout);
    // Written after each scene, so that an interrupted run keeps its results.
    STILLRAY_RETURN_IF_ERROR(WriteJson(options, *chosen, scenes));
  }
  return Status::Ok();
}

}  // namespace
}  // namespace stillray::render

int main(int argc, char** argv) {
  stillray::render::Options options;
  CLI::App app("Rays per second on a Vulkan device beside Embree");
  app.add_option("scenes", options.scenes, "builtin:NAME or a glTF file; none: the built-in ones");
  app.add_option("--device", options.device, "vulkan or vulkan:N");
  app.add_option("--size", options.size, "of the picture, WIDTHxHEIGHT");
  app.add_option("--repeats", options.repeats)->check(CLI::Range(1, 1000));
  app.add_option("--json", options.json_path, "Write the figures there too");
  CLI11_PARSE(app, argc, argv);
  const stillray::Status status = stillray::render::Run(options);
  if (!status.ok()) {
    std::fprintf(stderr, "gpu_trace_benchmark: %s\n", status.message().c_str());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
