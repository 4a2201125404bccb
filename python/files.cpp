// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Sequences of EXR files for the Python module: what `stillray denoise` does with them.
#include <cstdint>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <tbb/global_control.h>

#include "stillray/sequence.h"

namespace py = pybind11;
using namespace py::literals;  // NOLINT: argument names are written "name"_a

namespace {

using stillray::Result;
using stillray::Status;
using stillray::StatusCode;

/// Raises what stands for a failure in Python.
[[noreturn]] void Raise(const Status& status) {
  const py::module_ stillray_module = py::module_::import("stillray");
  const py::handle type = status.code() == StatusCode::kInvalidArgument ? PyExc_ValueError
                          : status.code() == StatusCode::kNotFound      ? PyExc_FileNotFoundError
                          : status.code() == StatusCode::kIo            ? PyExc_OSError
                          : status.code() == StatusCode::kOutOfMemory   ? PyExc_MemoryError
                          : status.code() == StatusCode::kCancelled
                              ? py::handle(stillray_module.attr("Cancelled"))
                              : py::handle(stillray_module.attr("Error"));
  PyErr_SetString(type.ptr(), status.message().c_str());
  throw py::error_already_set();
}

void Check(const Status& status) {
  if (!status.ok()) {
    Raise(status);
  }
}

/// Sets the window of the options. "auto" chooses by the files and the memory, as the program does.
void SetWindow(const std::string& name, stillray::SequenceOptions* options) {
  options->window_may_narrow = name == "auto";
  if (options->window_may_narrow) {
    std::string ignored;
    options->window = stillray::ChooseWindow(options->files, &ignored);
    return;
  }
  for (const stillray::Window window : {stillray::Window::kPast, stillray::Window::kBoth}) {
    if (name == stillray::WindowName(window)) {
      options->window = window;
      return;
    }
  }
  throw py::value_error(fmt::format("window is '{}', expected 'past', 'both' or 'auto'", name));
}

void SetMotion(const std::string& name, const std::string& cameras,
               stillray::SequenceOptions* options) {
  const std::optional<stillray::MotionSource> source = stillray::MotionSourceOf(name);
  if (!source) {
    throw py::value_error(
        fmt::format("motion is '{}', expected 'auto', 'file', 'camera' or 'estimate'", name));
  }
  options->motion = *source;
  options->cameras = cameras;
}

py::dict AsDict(const stillray::FrameReport& report) {
  py::dict stages;
  for (const stillray::LoggedStage& stage : report.stages) {
    stages[py::str(stage.name)] = stage.milliseconds;
  }
  return py::dict("frame"_a = report.frame, "input"_a = report.input, "output"_a = report.output,
                  "restarted"_a = report.restarted, "motion"_a = report.motion,
                  "motion_estimated"_a = report.motion_estimated,
                  "motion_unknown"_a = report.motion_unknown,
                  "images_missing"_a = report.images_missing, "note"_a = report.note,
                  "warning"_a = report.warning, "missing_light"_a = report.missing_light,
                  "bad_guides"_a = report.bad_guides, "read_ms"_a = report.read_ms,
                  "future_ms"_a = report.future_ms, "denoise_ms"_a = report.denoise_ms,
                  "write_ms"_a = report.write_ms, "stages_ms"_a = stages);
}

/// Calls of a run to Python, and what they raised.
class Calls {
 public:
  explicit Calls(py::object progress) : progress_(std::move(progress)) {}

  stillray::SequenceHooks Hooks() {
    stillray::SequenceHooks hooks;
    hooks.keep_going = [this] {
      const py::gil_scoped_acquire gil;
      return Guarded([] {
        if (PyErr_CheckSignals() != 0) {  // Ctrl-C
          throw py::error_already_set();
        }
        return true;
      });
    };
    hooks.note = [this](const std::string& text) {
      const py::gil_scoped_acquire gil;
      Guarded([&] {
        py::module_::import("logging").attr("getLogger")("stillray").attr("info")(text);
        return true;
      });
    };
    hooks.finished = [this](const stillray::FrameReport& report) {
      if (progress_.is_none()) {
        return;
      }
      const py::gil_scoped_acquire gil;
      Guarded([&] {
        const py::object answer = progress_(AsDict(report));
        return answer.is_none() || answer.cast<bool>();
      });
    };
    return hooks;
  }
  void Rethrow() const {
    if (raised_) {
      std::rethrow_exception(raised_);
    }
  }

 private:
  /// \return whether to go on
  template <typename Call>
  bool Guarded(const Call& call) {
    try {
      stopped_ = stopped_ || !call();
    } catch (...) {
      raised_ = raised_ ? raised_ : std::current_exception();
      stopped_ = true;
    }
    return !stopped_;
  }

  py::object progress_;
  bool stopped_ = false;
  std::exception_ptr raised_;
};

/// Makes the folder of a file.
Status MakeFolder(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (!folder.empty()) {
    std::filesystem::create_directories(folder, error);
  }
  return error ? Status(StatusCode::kIo, fmt::format("{}: {}", folder.string(), error.message()))
               : Status::Ok();
}

void SetAlpha(const std::string& alpha, stillray::SequenceOptions* options) {
  if (alpha != "keep" && alpha != "denoise") {
    throw py::value_error(fmt::format("alpha is '{}', expected 'keep' or 'denoise'", alpha));
  }
  options->denoise_alpha = alpha == "denoise";
}

py::list DenoiseFiles(const std::vector<std::string>& inputs, const std::string& output,
                      const std::string& frames, const std::string& window, int spp, bool passes,
                      const std::string& alpha, const std::string& preset,
                      const std::vector<std::pair<std::string, std::string>>& settings,
                      const std::string& motion, const std::string& cameras,
                      const std::string& renderer, const std::vector<std::string>& aovs,
                      const std::string& device_name, int threads, int64_t memory_limit,
                      bool resume, const py::object& progress) {
  stillray::SequenceOptions options;
  Result<std::vector<stillray::SequenceFile>> files =
      stillray::ListSequence(inputs, output, frames);
  Check(files.status());
  options.files = std::move(files.value());
  SetWindow(window, &options);
  SetMotion(motion, cameras, &options);
  if (spp < 0) {
    throw py::value_error(
        fmt::format("spp is {}, expected 1 or more, or 0: as the files state", spp));
  }
  options.spp = spp;
  options.passes = passes;
  SetAlpha(alpha, &options);
  options.overlap = threads != 1;
  options.aovs.renderer = renderer;
  options.aovs.mappings = aovs;
  options.memory.bytes = memory_limit;
  options.state.keep = options.state.resume = resume;
  Result<stillray::Settings> start = stillray::PresetSettings(preset);
  Check(start.status());
  options.settings = *start;
  for (const auto& [name, value] : settings) {
    Check(stillray::SetParameter(&options.settings, name, value));
    options.fixed_parameters.push_back(name);
  }
  std::optional<tbb::global_control> limit;
  if (threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  }
  Calls calls(progress);
  Status status;
  std::vector<stillray::FrameReport> reports;
  {
    const py::gil_scoped_release release;
    Result<stillray::SequenceDenoiser> denoiser = stillray::SequenceDenoiser::Create(
        options, [&] { return stillray::Device::Open(device_name); }, calls.Hooks());
    status = denoiser.status();
    if (status.ok()) {
      status = MakeFolder(options.files.front().output);
    }
    if (status.ok()) {
      status = denoiser->Run().status;
      reports = denoiser->reports();
    }
    if (status.ok()) {
      denoiser->RemoveState();
    }
  }
  calls.Rethrow();
  Check(status);
  py::list done;
  for (const stillray::FrameReport& report : reports) {
    done.append(AsDict(report));
  }
  return done;
}

}  // namespace

PYBIND11_MODULE(_files, m) {
  m.doc() = "The part of stillray that reads and writes files.";
  m.def("denoise_files", &DenoiseFiles);
}
