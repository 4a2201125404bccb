// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray bench: times of every stage, and the hardware limits, in one run.
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/bench_device.h"
#include "bench/bench_filter.h"
#include "bench/bench_frames.h"
#include "bench/bench_tracer.h"
#include "common/commands.h"
#include "common/console.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "common/json_output.h"
#include "common/progress.h"
#include "common/trace_device.h"
#include "core/clock.h"
#include "render/render_options.h"
#include "stillray/io.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

struct BenchArguments {
  RenderArguments render;  ///< scene, samples, bounces, settings
  std::vector<std::string> sizes = {"1280x720", "1920x1080"};
  std::vector<std::string> presets = {"svgf", "psvgf", "default"};
  std::vector<std::string> kernels = {"3x3", "5x5"};
  std::vector<std::string> set;  ///< "name=value", applied to every preset
  std::vector<int> threads = {1, 0};
  int repeats = 9;
  int warm_up = 4;  ///< frames that fill histories and touch memory for the first time
  bool scalar = true;
  std::string json_path;
  std::string device = "cpu";
  std::vector<std::string> precisions = {"half"};  ///< precision of the device's internal images
  std::vector<std::string> inputs = {"float"};     ///< input formats of frames on the device
  bool verbose = false;
  bool fps = false;
  bool download = true;  ///< download of denoised images from the device
};

/// One image size: each frame is rendered and then filtered by every configuration in turn.
struct BenchSize {
  std::string text;
  RenderOptions options;
  FilterBench filter;
  TracerBench tracer;
};

/// The settings of a preset, with the changes of the command line.
/// \param preset  NAME, or NAME:PARAMETER=VALUE:... with changes of this preset only
Result<Settings> SettingsOf(const BenchArguments& a, const std::string& preset, bool one_signal,
                            const std::string& kernel) {
  std::string_view changes = preset;
  const auto take = [&] {
    const std::string_view part = changes.substr(0, changes.find(':'));
    changes.remove_prefix(std::min(part.size() + 1, changes.size()));
    return part;
  };
  Result<Settings> settings = PresetSettings(take());
  if (!settings.ok()) {
    return settings;
  }
  STILLRAY_RETURN_IF_ERROR(SetParameter(&settings.value(), "kernel", kernel));
  if (one_signal) {
    STILLRAY_RETURN_IF_ERROR(SetParameter(&settings.value(), "signals", "single"));
  }
  for (const std::string& change : a.set) {
    const Status set = AssignParameter(&settings.value(), change);
    if (!set.ok()) {
      return Status::InvalidArgument("--set: " + set.message());
    }
  }
  while (!changes.empty()) {
    const Status set = AssignParameter(&settings.value(), take());
    if (!set.ok()) {
      return Status::InvalidArgument("--preset: " + set.message());
    }
  }
  return settings;
}

/// \param scalar  also the scalar reference
Status AddSubjects(const BenchArguments& a, int most_threads, bool scalar, FilterBench* filter) {
  const auto add = [&](const std::string& preset, bool one_signal, const std::string& kernel,
                       int threads, Backend backend) {
    const Result<Settings> settings = SettingsOf(a, preset, one_signal, kernel);
    if (!settings.ok()) {
      return settings.status();
    }
    const std::string name = preset + (one_signal ? ", one signal" : "");
    return filter->Add({name, kernel, threads, backend, *settings, one_signal});
  };
  for (const std::string& preset : a.presets) {
    for (const bool one_signal : {true, false}) {
      // Performance targets apply to the published filter with one signal.
      if (preset == "none" || (one_signal && preset != "svgf")) {
        continue;
      }
      for (const std::string& kernel : a.kernels) {
        for (const int threads : a.threads) {
          const int count = threads > 0 ? std::min(threads, most_threads) : most_threads;
          STILLRAY_RETURN_IF_ERROR(add(preset, one_signal, kernel, count, Backend::kCpu));
        }
        if (one_signal && scalar) {
          STILLRAY_RETURN_IF_ERROR(add(preset, true, kernel, 1, Backend::kReference));
        }
      }
    }
  }
  return Status::Ok();
}

RenderMoment MomentOf(const RenderOptions& options, int frame) {
  RenderMoment moment;
  moment.frame_index = frame;
  moment.seconds = options.Seconds(frame);
  moment.previous_seconds = options.PreviousSeconds(frame);
  return moment;
}

/// Traces the frames of one size in order.
/// \param use  called as use(frame, milliseconds of tracing, whether they count)
template <typename Use>
Status ForFrames(const BenchArguments& a, const RenderOptions& options, const std::string& text,
                 Renderer* renderer, const Use& use) {
  const int frames = a.warm_up + a.repeats;
  Progress progress(frames, stderr);
  Frame frame;
  for (int i = 1; i <= frames; ++i) {
    const Clock::time_point start = Clock::now();
    STILLRAY_RETURN_IF_ERROR(
        renderer->RenderFrame(MomentOf(options, i), &frame, [](double) { return !Interrupted(); }));
    const double ms = MillisecondsSince(start);
    STILLRAY_RETURN_IF_ERROR(use(frame, ms, i > a.warm_up));
    progress.Update(i, fmt::format("{} frame {}", text, i));
  }
  return Status::Ok();
}

Status Measure(const BenchArguments& a, const Scene& scene, BenchSize* size) {
  const RenderOptions& options = size->options;
  const Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(scene, options.render);
  STILLRAY_RETURN_IF_ERROR(renderer.status());
  STILLRAY_RETURN_IF_ERROR(size->tracer.MeasureLoading(options.text.scene, options.render));
  STILLRAY_RETURN_IF_ERROR(size->tracer.Prepare(scene, options.render, MomentOf(options, 1)));
  return ForFrames(a, options, size->text, renderer->get(),
                   [&](const Frame& frame, double ms, bool record) {
                     if (record) {
                       size->tracer.AddFrame((*renderer)->timings(), ms);
                       size->tracer.RunBare();
                     }
                     return size->filter.Run(frame, record);
                   });
}

std::string Title(const BenchArguments& a, const BenchSize& size, int threads) {
  const RenderOptions& o = size.options;
  return fmt::format("{}{}, {}x{}, {} spp, {} bounces, {} threads, {} interleaved repeats\n\n",
                     o.text.scene, o.text.still ? ", still" : "", o.render.width, o.render.height,
                     GetRenderParameter(o.render, "spp").value(), o.render.bounces, threads,
                     a.repeats);
}

std::string BenchJson(const BenchArguments& a, const std::vector<BenchSize>& sizes, int threads) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const BenchSize& size : sizes) {
    list.push_back({{"width", size.options.render.width},
                    {"height", size.options.render.height},
                    {"filter", size.filter.Json()},
                    {"tracing", size.tracer.Json()}});
  }
  const RenderOptions& o = sizes.front().options;
  const Json json = {{"stillray", STILLRAY_VERSION},
                     {"scene", o.text.scene},
                     {"spp", SamplesPerPixel(o.render)},
                     {"guides", GetRenderParameter(o.render, "guides").value()},
                     {"bounces", o.render.bounces},
                     {"still", o.text.still},
                     {"warm_up", a.warm_up},
                     {"threads", threads},
                     {"repeats", a.repeats},
                     {"sizes", list}};
  return JsonText(json);
}

/// Options of the renderer at one of the sizes.
Result<RenderOptions> OptionsAt(const BenchArguments& a, const std::string& size) {
  RenderArguments render = a.render;
  render.size = size;
  return ParseRenderArguments(render);
}

Status WriteJson(const BenchArguments& a, const std::string& json) {
  return a.json_path.empty() ? Status::Ok() : WriteJsonOutput(a.json_path, json);
}

/// Adds one size and filter, in every precision and with every input format.
void AddDeviceSubjects(const BenchArguments& a, const DeviceSubject& subject,
                       std::vector<DeviceSubject>* subjects) {
  for (const std::string& precision : a.precisions) {
    for (const std::string& inputs : a.inputs) {
      DeviceSubject added = subject;
      added.options.precision =
          precision == "float" ? DevicePrecision::kFloat : DevicePrecision::kHalf;
      added.options.inputs = inputs == "packed" ? BenchInputs::kPacked : BenchInputs::kFloat;
      subjects->push_back(added);
    }
  }
}

/// Benchmarks the denoiser alone, on a device: its stages and a copy, with a procedural image.
Status RunDeviceBench(const BenchArguments& a) {
  std::vector<DeviceSubject> subjects;
  for (const std::string& size : a.sizes) {
    const Result<RenderOptions> options = OptionsAt(a, size);
    STILLRAY_RETURN_IF_ERROR(options.status());
    for (const std::string& preset : a.presets) {
      for (const std::string& kernel : a.kernels) {
        const Result<Settings> settings = SettingsOf(a, preset, false, kernel);
        STILLRAY_RETURN_IF_ERROR(settings.status());
        DeviceSubject subject = {preset, kernel, {}};
        subject.options.settings = *settings;
        subject.options.width = options->render.width;
        subject.options.height = options->render.height;
        subject.options.repeats = a.repeats;
        AddDeviceSubjects(a, subject, &subjects);
      }
    }
  }
  nlohmann::ordered_json all;
  const bool to_file = a.json_path != "-";
  STILLRAY_RETURN_IF_ERROR(
      BenchSubjectsOnDevice(a.device, subjects, [&](const nlohmann::ordered_json& figures) {
        all = figures;
        return to_file ? WriteJson(a, JsonText(figures)) : Status::Ok();
      }));
  return to_file ? Status::Ok() : WriteJson(a, JsonText(all));
}

/// Measures complete frames of one size, each traced once and filtered by all configurations.
Status MeasureFrames(const BenchArguments& a, const RenderOptions& options, const std::string& text,
                     DeviceRenderer* renderer, FramesBench* bench) {
  STILLRAY_RETURN_IF_ERROR(
      ForFrames(a, options, text, renderer, [&](const Frame& frame, double ms, bool record) {
        return bench->Run(frame, {ms, DeviceTimeOf(*renderer)}, record);
      }));
  bench->SetTracerBytes(renderer->memory_bytes());
  return Status::Ok();
}

/// Creates a renderer on the device, with a fallback to the CPU if "auto" chose the device.
Result<std::unique_ptr<DeviceRenderer>> MakeRenderer(const BenchArguments& a, const Device& device,
                                                     const Scene& scene,
                                                     const RenderSettings& settings) {
  TraceOptions options;
  options.may_fall_back = a.device == "auto";
  options.keep_going = [] { return !Interrupted(); };
  Result<std::unique_ptr<DeviceRenderer>> made =
      DeviceRenderer::Create(device, scene, settings, options);
  if (made.ok()) {
    if (const std::string remark = (*made)->TakeRemark(); !remark.empty()) {
      PrintTo(stderr, "tracing on the CPU: {}\n", remark);
    }
  }
  return made;
}

/// Measures complete frames: tracing alone, with the temporal stage, with complete SVGF.
Status RunFramesBench(const BenchArguments& a) {
  CatchInterrupts();
  const Result<Device> device = OpenDeviceOption(a.device, a.verbose, "rendering");
  STILLRAY_RETURN_IF_ERROR(device.status());
  const Result<Scene> scene = LoadScene(a.render.scene, [] { return !Interrupted(); });
  STILLRAY_RETURN_IF_ERROR(scene.status());
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const std::string& size : a.sizes) {
    const Result<RenderOptions> options = OptionsAt(a, size);
    STILLRAY_RETURN_IF_ERROR(options.status());
    FramesBench bench(a.download);
    STILLRAY_RETURN_IF_ERROR(bench.Add("raw tracing", nullptr, *device));
    bool reads_images = false;
    for (const auto& [name, preset] :
         {std::pair{"temporal only", "temporal"}, std::pair{"full SVGF", "svgf"}}) {
      const Result<Settings> settings = SettingsOf(a, preset, false, a.kernels.back());
      STILLRAY_RETURN_IF_ERROR(settings.status());
      STILLRAY_RETURN_IF_ERROR(bench.Add(name, &*settings, *device));
      reads_images = reads_images || settings->virtual_roughness > 0;
    }
    RenderSettings settings = options->render;
    settings.virtual_guides = settings.virtual_guides && reads_images;
    settings.on_device = true;
    const Result<std::unique_ptr<DeviceRenderer>> renderer =
        MakeRenderer(a, *device, *scene, settings);
    STILLRAY_RETURN_IF_ERROR(renderer.status());
    STILLRAY_RETURN_IF_ERROR(MeasureFrames(a, *options, size, renderer->get(), &bench));
    PrintTo(stdout,
            "{}{}, {}x{}, {} spp, {} bounces, {} frames; traced on {}, filtered on {}{}\n\n",
            a.render.scene, options->text.still ? ", still" : "", options->render.width,
            options->render.height, GetRenderParameter(options->render, "spp").value(),
            options->render.bounces, a.repeats, (*renderer)->place(), device->description(),
            a.download ? "" : ", pictures stay there");
    WriteText(stdout, bench.Table() + "\n");
    nlohmann::ordered_json json = bench.Json();
    json["width"] = options->render.width;
    json["height"] = options->render.height;
    json["tracer"] = (*renderer)->place();
    list.push_back(json);
  }
  const nlohmann::ordered_json json = {{"stillray", STILLRAY_VERSION},    {"scene", a.render.scene},
                                       {"device", device->description()}, {"frames", a.repeats},
                                       {"downloads", a.download},         {"sizes", list}};
  return WriteJson(a, JsonText(json));
}

/// \param device  omit presets with stages that only the CPU supports
std::vector<std::string> AllPresets(bool device) {
  std::vector<std::string> names;
  for (const std::string_view name : PresetNames()) {
    if (!device || !PresetSettings(name)->restore_detail) {
      names.emplace_back(name);
    }
  }
  return names;
}

Status RunBench(const BenchArguments& given) {
  BenchArguments arguments = given;
  if (arguments.presets == std::vector<std::string>{"all"}) {
    arguments.presets = AllPresets(arguments.device != "cpu");
  }
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(arguments.json_path));
  if (arguments.fps) {
    return RunFramesBench(arguments);
  }
  if (arguments.device != "cpu") {
    return RunDeviceBench(arguments);
  }
  const int most_threads = tbb::info::default_concurrency();
  const int asked = *std::max_element(arguments.threads.begin(), arguments.threads.end());
  const bool all =
      std::find(arguments.threads.begin(), arguments.threads.end(), 0) != arguments.threads.end();
  const int threads = all ? most_threads : std::min(asked, most_threads);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  CatchInterrupts();
  std::vector<BenchSize> sizes(arguments.sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    sizes[i].text = arguments.sizes[i];
    Result<RenderOptions> options = OptionsAt(arguments, sizes[i].text);
    STILLRAY_RETURN_IF_ERROR(options.status());
    sizes[i].options = std::move(options.value());
    STILLRAY_RETURN_IF_ERROR(
        AddSubjects(arguments, threads, arguments.scalar && i == 0, &sizes[i].filter));
  }
  const Result<Scene> scene = LoadScene(arguments.render.scene);
  if (!scene.ok()) {
    return scene.status();
  }
  for (BenchSize& size : sizes) {
    STILLRAY_RETURN_IF_ERROR(Measure(arguments, *scene, &size));
    WriteText(stdout, fmt::format("{}{}{}\n", Title(arguments, size, threads),
                                  size.filter.empty() ? "" : size.filter.Table() + "\n",
                                  size.tracer.Table()));
  }
  return WriteJson(arguments, BenchJson(arguments, sizes, threads));
}

constexpr const char* kExamples = R"(
Frames are rendered one by one and each is given to every filter in turn, so that a slow moment of
the machine meets all of them alike; compare ratios rather than milliseconds.
"one signal": all light comes as one signal with one albedo, as the copy's bytes assume.
x copy: median over that of a copy of the least bytes that such a filter must read and write.
scalar x: least time of the scalar reference on one thread over the filter's.
atrous x peak: least time of the wavelet over that of its arithmetic at the peak rate; the time is
that of prefilter_variance too where this has none of its own.
"Embree": what the fastest of its calls makes of the rays of the first frame, in the same order, in
a loop that does nothing else; least times of the same run.

Examples:
  stillray bench
  stillray bench --size 1920x1080 --preset svgf --repeats 21 --json bench.json
  stillray bench --scene kitchen.glb --size 1280x720 --threads 0
  stillray bench --preset none                the path tracer alone
  stillray bench --size 1366x690 --spp 1/128 --guides sparse --preset psvgf --kernel 3x3 --threads 0
  stillray bench --spp 1/128 --guides sparse --still --warm-up 128 --preset psvgf
  stillray bench --preset svgf --set sigma_n=32 --no-scalar
  stillray bench --preset svgf,svgf:sigma_n=32 --kernel 5x5 --no-scalar
  stillray bench --device vulkan --preset svgf --kernel 5x5 --set signals=single
  stillray bench --device vulkan --precision half,float --inputs float,packed
  stillray bench --fps --device auto          frames per second; camera, objects and lamp move
)";

}  // namespace

void AddBenchCommand(CLI::App& app, int* exit_code) {
  CLI::App* command =
      app.add_subcommand("bench", "Measure every stage of the denoiser, and the path tracer");
  command->footer(kExamples);
  const auto a = std::make_shared<BenchArguments>();
  a->render.scene = "builtin:cornell";
  a->render.folder = ".";
  a->render.tracer.defaults.bounces = 1;
  CLI::Option* scene =
      command->add_option("--scene", a->render.scene, ".gltf, .glb, .obj or builtin:NAME")
          ->capture_default_str();
  command->add_option("--size", a->sizes, "WIDTHxHEIGHT in pixels: a list")
      ->delimiter(',')
      ->take_all()
      ->capture_default_str();
  AddTracerOptions(command, &a->render.tracer);
  command
      ->add_option("--preset", a->presets,
                   "Presets to measure: a list, all, or none; "
                   "NAME:PARAMETER=VALUE:... with changes")
      ->delimiter(',')
      ->take_all()
      ->capture_default_str();
  command
      ->add_option("--repeats", a->repeats,
                   "Frames that are measured; with --device of the filter: submissions of frames")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--warm-up", a->warm_up, "Frames before those")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command->add_flag("--still", a->render.still, "The first frame's view and moment in all of them");
  command->add_option("--kernel", a->kernels, "Kernels of the wavelet: a list")
      ->delimiter(',')
      ->take_all()
      ->capture_default_str();
  command->add_option("--set", a->set, "Parameter of the denoiser as NAME=VALUE; repeatable");
  command->add_flag(
      "--scalar,!--no-scalar", a->scalar,
      "Also the scalar reference of preset svgf with one signal, at the first size (slow; "
      "default)");
  command->add_option("--threads", a->threads, "Threads of the filter: a list; 0: all processors")
      ->delimiter(',')
      ->take_all()
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command
      ->add_option("--device", a->device,
                   "cpu; or vulkan, vulkan:N: the denoiser alone, beside a copy on that device; "
                   "with --fps also auto")
      ->capture_default_str();
  command
      ->add_option("--precision", a->precisions,
                   "half, float: of the images on the --device, a list")
      ->delimiter(',')
      ->take_all()
      ->check(CLI::IsMember({"half", "float"}))
      ->capture_default_str();
  command
      ->add_option("--inputs", a->inputs,
                   "float: frames on the --device as the path tracer writes them; packed: as "
                   "halves and 8 bits; a list")
      ->delimiter(',')
      ->take_all()
      ->check(CLI::IsMember({"float", "packed"}))
      ->capture_default_str();
  AddVerboseOption(command, &a->verbose);
  command->add_flag("--fps", a->fps,
                    "Whole frames per second instead, and memory: tracing alone, with preset "
                    "temporal, with preset svgf; of builtin:lights if no scene is given");
  command->add_flag("--download,!--no-download", a->download,
                    "With --fps: copy pictures from the device to the host (default)");
  command->add_option("--json", a->json_path, "Write the figures there too");
  command->callback([a, scene, exit_code] {
    if (a->fps && scene->count() == 0) {
      a->render.scene = "builtin:lights";
    }
    const Status status = RunBench(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
