// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray bench: milliseconds of every stage, beside what limits them, in one run.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <nlohmann/json.hpp>

#include "bench_tracer.h"
#include "commands.h"
#include "interrupt.h"
#include "progress.h"
#include "render_options.h"
#include "stillray/io.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

using Clock = std::chrono::steady_clock;

double Milliseconds(Clock::time_point since) {
  return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

struct BenchArguments {
  RenderArguments render;  ///< scene, size, samples, bounces
  std::vector<std::string> presets = {"default", "svgf", "eaw"};
  int repeats = 11;
  bool reference = false;
  std::string json_path;
};

/// All times of one thing, one per repeat.
struct Times {
  std::string name;
  std::vector<double> ms;

  double Min() const { return *std::min_element(ms.begin(), ms.end()); }
  double Median() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

Times& Find(std::vector<Times>* table, const std::string& name) {
  const auto at =
      std::find_if(table->begin(), table->end(), [&](const Times& t) { return t.name == name; });
  if (at != table->end()) {
    return *at;
  }
  table->push_back({name, {}});
  return table->back();
}

/// One denoiser under test.
struct Subject {
  std::string name;
  Denoiser denoiser;
  std::vector<Times> stages;  ///< "whole" first
  size_t bytes = 0;

  Status Run(const Frame& frame, bool record) {
    DenoisedFrame out;
    const Clock::time_point start = Clock::now();
    STILLRAY_RETURN_IF_ERROR(denoiser.Denoise(frame, &out));
    const double whole = Milliseconds(start);
    if (record) {
      Find(&stages, "whole").ms.push_back(whole);
      for (const StageTime& stage : out.timings) {
        Find(&stages, stage.name).ms.push_back(stage.milliseconds);
      }
      bytes = denoiser.memory_bytes();
    }
    return Status::Ok();
  }
};

/// Reads and writes as many bytes as a filter must at least: all of a frame in, a picture out.
class MinimalCopy {
 public:
  explicit MinimalCopy(const Frame& frame) {
    const size_t pixels = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
    // Signals, normal, two albedos: 3 floats each; depth, motion, id; the result.
    read_ = pixels * 4 * (frame.signals.size() * 3 + 9 + 4);
    write_ = pixels * 4 * 3;
    from_.assign(read_, 1);
    to_.assign(read_, 0);
  }
  size_t bytes() const { return read_ + write_; }

  double Milliseconds() {
    // A copy of n bytes reads n and writes n: half of the sum.
    const size_t n = (read_ + write_) / 2;
    const size_t block = size_t{1} << 20;
    const Clock::time_point start = Clock::now();
    tbb::parallel_for(size_t{0}, (n + block - 1) / block, [&](size_t i) {
      std::memcpy(to_.data() + i * block, from_.data() + i * block, std::min(block, n - i * block));
    });
    return stillray::Milliseconds(start);
  }

 private:
  size_t read_ = 0;
  size_t write_ = 0;
  std::vector<char> from_;
  std::vector<char> to_;
};

class Bench {
 public:
  Bench(const BenchArguments& arguments, RenderOptions options, int threads)
      : arguments_(arguments), options_(std::move(options)), threads_(threads) {}

  Status Run();

 private:
  Status AddSubjects();
  Status Measure(Renderer* renderer);
  std::string Table() const;
  std::string Json() const;

  const BenchArguments& arguments_;
  RenderOptions options_;
  int threads_;
  std::vector<Subject> subjects_;
  Times copy_ = {"copy", {}};
  size_t copy_bytes_ = 0;
  TracerBench tracer_;
};

Status Bench::AddSubjects() {
  const auto add = [&](const std::string& preset, Backend backend, const std::string& name) {
    Result<Settings> settings = PresetSettings(preset);
    if (!settings.ok()) {
      return settings.status();
    }
    Result<Denoiser> denoiser = Denoiser::Create(*settings, backend);
    if (!denoiser.ok()) {
      return denoiser.status();
    }
    subjects_.push_back({name, std::move(denoiser.value()), {}, 0});
    return Status::Ok();
  };
  for (const std::string& preset : arguments_.presets) {
    if (preset == "none") {
      continue;
    }
    STILLRAY_RETURN_IF_ERROR(add(preset, Backend::kCpu, preset));
    if (arguments_.reference) {
      STILLRAY_RETURN_IF_ERROR(add(preset, Backend::kReference, preset + ", scalar"));
    }
  }
  return Status::Ok();
}

Status Bench::Measure(Renderer* renderer) {
  // The first frames fill histories and touch memory for the first time.
  constexpr int kWarmUp = 4;
  Progress progress(kWarmUp + arguments_.repeats, stderr);
  Frame frame;
  std::unique_ptr<MinimalCopy> copy;
  for (int i = 1; i <= kWarmUp + arguments_.repeats; ++i) {
    RenderMoment moment;
    moment.frame_index = i;
    moment.seconds = options_.Seconds(i);
    moment.previous_seconds = options_.PreviousSeconds(i);
    const Clock::time_point start = Clock::now();
    STILLRAY_RETURN_IF_ERROR(
        renderer->RenderFrame(moment, &frame, [](double) { return !Interrupted(); }));
    const double frame_ms = Milliseconds(start);
    const bool record = i > kWarmUp;
    if (record) {
      tracer_.AddFrame(renderer->timings(), frame_ms);
      tracer_.RunBare();
    }
    if (!copy) {
      copy = std::make_unique<MinimalCopy>(frame);
      copy_bytes_ = copy->bytes();
    }
    for (Subject& subject : subjects_) {
      STILLRAY_RETURN_IF_ERROR(subject.Run(frame, record));
    }
    if (record) {
      copy_.ms.push_back(copy->Milliseconds());
    }
    progress.Update(i, fmt::format("frame {}", i));
  }
  return Status::Ok();
}

std::string Bench::Table() const {
  std::string text = fmt::format(
      "{}, {}x{}, {} spp, {} bounces, {} threads, {} interleaved repeats\n\n", options_.text.scene,
      options_.render.width, options_.render.height, SamplesPerPixelText(options_.render),
      options_.render.bounces, threads_, arguments_.repeats);
  for (const Subject& subject : subjects_) {
    text +=
        fmt::format("{:<24}{:>10}{:>10}{:>12}\n", subject.name, "min ms", "median ms", "x copy");
    for (const Times& t : subject.stages) {
      text += fmt::format("  {:<22}{:>10.2f}{:>10.2f}{:>12.1f}\n", t.name, t.Min(), t.Median(),
                          t.Median() / copy_.Median());
    }
    text +=
        fmt::format("  {:<22}{:>10.1f} MB\n\n", "memory", static_cast<double>(subject.bytes) / 1e6);
  }
  text += fmt::format("copy of {:.1f} MB: {:.2f} ms (min {:.2f})\n",
                      static_cast<double>(copy_bytes_) / 2e6, copy_.Median(), copy_.Min());
  return text + tracer_.Table();
}

std::string Bench::Json() const {
  using Json = nlohmann::ordered_json;
  Json subjects = Json::array();
  for (const Subject& subject : subjects_) {
    Json stages = Json::object();
    for (const Times& t : subject.stages) {
      stages[t.name] = {{"min_ms", t.Min()}, {"median_ms", t.Median()}};
    }
    subjects.push_back({{"name", subject.name}, {"stages", stages}, {"bytes", subject.bytes}});
  }
  const Json json = {{"stillray", STILLRAY_VERSION},
                     {"scene", options_.text.scene},
                     {"width", options_.render.width},
                     {"height", options_.render.height},
                     {"spp", SamplesPerPixel(options_.render)},
                     {"guides", options_.text.guides},
                     {"bounces", options_.render.bounces},
                     {"threads", threads_},
                     {"repeats", arguments_.repeats},
                     {"denoisers", subjects},
                     {"copy", {{"bytes", copy_bytes_ / 2}, {"median_ms", copy_.Median()}}},
                     {"tracing", tracer_.Json()}};
  return json.dump(1) + "\n";
}

Status Bench::Run() {
  STILLRAY_RETURN_IF_ERROR(AddSubjects());
  const Result<Scene> scene = LoadScene(options_.text.scene);
  if (!scene.ok()) {
    return scene.status();
  }
  Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*scene, options_.render);
  if (!renderer.ok()) {
    return renderer.status();
  }
  RenderMoment moment;
  moment.frame_index = 1;
  moment.seconds = options_.Seconds(1);
  moment.previous_seconds = options_.PreviousSeconds(1);
  STILLRAY_RETURN_IF_ERROR(tracer_.Prepare(*scene, options_.render, moment));
  STILLRAY_RETURN_IF_ERROR(Measure(renderer->get()));
  fmt::print("{}", Table());
  if (arguments_.json_path.empty()) {
    return Status::Ok();
  }
  const std::string json = Json();
  return WriteFileAtomically(arguments_.json_path, json.data(), json.size());
}

Status RunBench(const BenchArguments& arguments) {
  Result<RenderOptions> options = ParseRenderArguments(arguments.render);
  if (!options.ok()) {
    return options.status();
  }
  const int available = tbb::info::default_concurrency();
  const int threads = arguments.render.threads > 0 ? arguments.render.threads : available;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  CatchInterrupts();
  return Bench(arguments, std::move(options.value()), threads).Run();
}

constexpr const char* kExamples = R"(
Frames are rendered one by one and each is given to every denoiser in turn, so that a slow moment of
the machine meets all of them alike. "x copy" is the median over that of a copy of the least bytes
that any filter must read and write, measured in the same run.
"Embree": what the fastest of its calls makes of the rays of the first frame, in the same order, in
a loop that does nothing else; least times of the same run.

Examples:
  stillray bench
  stillray bench --size 1920x1080 --preset svgf --repeats 21 --json bench.json
  stillray bench --scene kitchen.glb --threads 1
  stillray bench --preset none                the path tracer alone
  stillray bench --size 1366x690 --spp 1/128 --guides sparse --bounces 4
  stillray bench --size 320x180 --scalar      beside the scalar reference
)";

}  // namespace

void AddBenchCommand(CLI::App& app, int* exit_code) {
  CLI::App* command =
      app.add_subcommand("bench", "Measure every stage of the denoiser, and the path tracer");
  command->footer(kExamples);
  const auto a = std::make_shared<BenchArguments>();
  a->render.scene = "builtin:cornell";
  a->render.folder = ".";
  a->render.bounces = 1;
  command->add_option("--scene", a->render.scene, ".gltf, .glb or builtin:NAME")
      ->capture_default_str();
  command->add_option("--size", a->render.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command
      ->add_option(
          "--spp", a->render.spp,
          "Paths per pixel and frame; 1/2 to 1/256: one path per pixel in that many frames")
      ->capture_default_str();
  command
      ->add_option("--guides", a->render.guides,
                   "With --spp below 1: full, or sparse (known only where a path was traced)")
      ->capture_default_str();
  command->add_option("--bounces", a->render.bounces, "Bounces of the path tracer")
      ->capture_default_str();
  command->add_option("--preset", a->presets, "Presets to measure: a list, or none")
      ->delimiter(',')
      ->take_all()
      ->capture_default_str();
  command->add_option("--repeats", a->repeats, "Frames that are measured")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_flag("--scalar", a->reference, "Also the scalar reference (slow)");
  command->add_option("--threads", a->render.threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->add_option("--json", a->json_path, "Write the figures there too");
  command->callback([a, exit_code] {
    const Status status = RunBench(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
