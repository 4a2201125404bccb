// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray check: finds defects of a sequence before it is denoised.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/commands.h"
#include "common/console.h"
#include "common/finding_json.h"
#include "common/interrupt.h"
#include "common/json_output.h"
#include "common/progress.h"
#include "common/sequence_options.h"
#include "io/memory_limit.h"
#include "io/text.h"
#include "stillray/doctor.h"
#include "stillray/sequence.h"

namespace stillray {
namespace {

struct CheckArguments {
  std::vector<std::string> inputs;
  std::string frames;
  AovOptions aovs;
  int threads = 0;
  bool measures = false;
  std::string json_path;
};

constexpr size_t kMaxFileBytes = size_t{4} << 30;
/// Memory of two frames with all guides and the data of the checks: 700 B per pixel with 35
/// channels.
constexpr ExrCost kCost = {450, 8};

/// Placeholder for the output path of a listing, which writes no files.
constexpr const char* kNowhere = "/nonexistent/frame.####.exr";

std::string ReportJson(const DoctorReport& report, const std::vector<SequenceFile>& files) {
  nlohmann::ordered_json json;
  json["stillray"] = STILLRAY_VERSION;
  json["clean"] = report.findings.empty();
  json["renderer"] = report.layout.renderer;
  json["first_file"] = io::OneLine(files.front().input);
  json["frames"] = report.frames;
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& f : report.findings) {
    json["findings"].push_back(FindingJson(f));
  }
  json["measures"] = nlohmann::ordered_json::array();
  for (const Measure& m : report.measures) {
    json["measures"].push_back({{"name", m.name},
                                {"value", FiniteNumberJson(m.value)},
                                {"limit", FiniteNumberJson(m.limit)},
                                {"broken", m.broken},
                                {"judged", m.judged}});
  }
  return JsonText(json, 2);
}

void PrintReport(const DoctorReport& report, bool measures, std::FILE* out) {
  for (const Finding& f : report.findings) {
    PrintTo(out, "\n{}\n  {}\n  cure: {}\n", f.name, f.what, f.cure);
  }
  if (measures) {
    PrintTo(out, "\n{:<34} {:>12} {:>12} {:>8}\n", "measure", "value", "limit", "judged");
    for (const Measure& m : report.measures) {
      PrintTo(out, "{:<34} {:>12.4g} {:>12.4g} {:>8}{}\n", m.name, m.value, m.limit, m.judged,
              m.broken ? "  *" : "");
    }
  }
  const size_t count = report.findings.size();
  PrintTo(out, "\n{} frames: {}\n", report.frames.size(),
          count == 0   ? "nothing wrong was found"
          : count == 1 ? "1 finding"
                       : fmt::format("{} findings", count));
}

Status LookAt(const SequenceFile& file, std::FILE* out, Doctor* doctor) {
  const Result<std::string> bytes = ReadWholeFile(file.input, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  STILLRAY_RETURN_IF_ERROR(CheckExrFits(*bytes, file.input, kCost));
  const Result<ExrImage> image =
      DecodeExr(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), file.input);
  if (!image.ok()) {
    return image.status();
  }
  const bool first = doctor->layout() == nullptr;
  STILLRAY_RETURN_IF_ERROR(doctor->Add(file.frame, file.input, *image));
  if (first) {
    WriteText(out, AovTable(*doctor->layout()));
    std::fflush(out);
  }
  return Status::Ok();
}

Status RunCheck(const CheckArguments& a, bool* clean) {
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(a.json_path));
  const Result<std::vector<SequenceFile>> files = ListSequence(a.inputs, kNowhere, a.frames);
  if (!files.ok()) {
    return files.status();
  }
  const int threads = a.threads > 0 ? a.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  SetExrThreads(threads > 1 ? threads : 0);
  CatchInterrupts();
  std::FILE* out = a.json_path == "-" ? stderr : stdout;
  const std::unique_ptr<Doctor> doctor = Doctor::Create(a.aovs);
  {
    Progress progress(static_cast<double>(files->size()), stderr);
    for (size_t i = 0; i < files->size(); ++i) {
      if (Interrupted()) {
        progress.Clear();
        return Status(StatusCode::kCancelled,
                      fmt::format("stopped; {} of {} frames were looked at", i, files->size()));
      }
      const Status status = LookAt((*files)[i], out, doctor.get());
      if (!status.ok()) {
        progress.Clear();
        return status;
      }
      progress.Update(static_cast<double>(i + 1), fmt::format("frame {}", (*files)[i].frame));
    }
  }
  const Result<DoctorReport> report = doctor->Report();
  if (!report.ok()) {
    return report.status();
  }
  *clean = report->findings.empty();
  PrintReport(*report, a.measures, out);
  if (a.json_path.empty()) {
    return Status::Ok();
  }
  const std::string json = ReportJson(*report, *files);
  return WriteJsonOutput(a.json_path, json);
}

constexpr const char* kExamples = R"(
Exit code: 0 no findings, 3 findings, 2 input that cannot be read. Every finding names the frames,
the measured and the expected value, and the cure. docs/check.md lists them all.

Examples:
  stillray check 'shot.####.exr'
  stillray check frames/ --frames 1-24 --renderer blender --json report.json
  stillray check 'shot.%04d.exr' --aov motion=mv,ndc,from_previous,y_up --measures
)";

}  // namespace

void AddCheckCommand(CLI::App& app, int* exit_code) {
  CLI::App* command =
      app.add_subcommand("check", "Find faults of a sequence of EXR files before denoising it");
  command->footer(kExamples);
  const auto a = std::make_shared<CheckArguments>();
  AddSequenceOptions(command, &a->inputs, &a->frames, &a->aovs);
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->add_flag("--measures", a->measures,
                    "Print every measure with its limit, exceeded or not");
  command->add_option("--json", a->json_path,
                      "Write findings and measures there (- for standard output)");
  command->callback([a, exit_code] {
    bool clean = false;
    const Status status = RunCheck(*a, &clean);
    *exit_code = !status.ok() ? ReportError(status) : clean ? kExitOk : kExitFindings;
  });
}

}  // namespace stillray
