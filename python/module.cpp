// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The Python module: the C API with NumPy arrays.
#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "stillray/stillray.hpp"

namespace py = pybind11;
using namespace py::literals;  // NOLINT: argument names are written "name"_a

namespace {

/// Errors that have no counterpart among Python's own.
struct ApiError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct CancelledError : ApiError {
  using ApiError::ApiError;
};

void Check(const stillray::api::Error& error) {
  switch (error.code) {
    case STILLRAY_OK:
      return;
    case STILLRAY_ERROR_INVALID_ARGUMENT:
      throw py::value_error(error.message);
    case STILLRAY_ERROR_OUT_OF_MEMORY:
      throw std::bad_alloc();
    case STILLRAY_ERROR_CANCELLED:
      throw CancelledError(error.message);
    default:
      throw ApiError(error.message);
  }
}

/// A setting as text: True is "on", [1, 2] is "1,2", 0.1 is "0.1".
std::string TextOf(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) {
    return value.cast<bool>() ? "on" : "off";
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    std::string text;
    for (const py::handle item : value) {
      text += (text.empty() ? "" : ",") + TextOf(item);
    }
    return text;
  }
  return py::str(value);
}

std::string ShapeOf(const py::array& array) {
  return py::str(array.attr("shape"));
}

/// The memory of an array; it must outlive the description.
stillray_image Describe(const std::string& name, const py::array& array, bool writeable) {
  stillray_image image = {};
  if (array.dtype().equal(py::dtype::of<float>())) {
    image.format = STILLRAY_FORMAT_FLOAT;
  } else if (array.dtype().equal(py::dtype("float16"))) {
    image.format = STILLRAY_FORMAT_HALF;
  } else if (array.dtype().equal(py::dtype::of<uint32_t>())) {
    image.format = STILLRAY_FORMAT_UINT32;
  } else {
    throw py::type_error(fmt::format("image '{}' is of type {}, expected float32, float16{}", name,
                                     std::string(py::str(array.dtype())),
                                     name == "id" ? " or uint32" : ""));
  }
  if (array.ndim() != 2 && array.ndim() != 3) {
    throw py::value_error(fmt::format(
        "image '{}' has the shape {}, expected (height, width) or (height, width, channels)", name,
        ShapeOf(array)));
  }
  if (writeable && !array.writeable()) {
    throw py::value_error(fmt::format("image '{}' is read-only", name));
  }
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis) {
    if (array.strides(axis) == 0 && array.shape(axis) > 1 && array.size() > 0) {
      throw py::value_error(
          fmt::format("image '{}' repeats values along axis {} (a broadcast view)", name, axis));
    }
    if (array.shape(axis) > 32768) {
      throw py::value_error(
          fmt::format("image '{}' has the shape {}, expected at most 32768 pixels to a side", name,
                      ShapeOf(array)));
    }
  }
  image.data = const_cast<void*>(array.data());
  image.height = static_cast<int32_t>(array.shape(0));
  image.width = static_cast<int32_t>(array.shape(1));
  image.channels = array.ndim() == 3 ? static_cast<int32_t>(array.shape(2)) : 1;
  image.row_stride = array.strides(0);
  image.pixel_stride = array.strides(1);
  image.channel_stride = array.ndim() == 3 ? array.strides(2) : array.itemsize();
  return image;
}

bool HasThreeChannels(const std::string& output) {
  return output == "colour" || output == "temporal" || output == "aliased" ||
         output.rfind("atrous", 0) == 0 || output.rfind("noisy.", 0) == 0 ||
         output.rfind("accumulated.", 0) == 0 || output.rfind("filtered.", 0) == 0;
}

py::array_t<float> MakeResult(const std::string& output, py::ssize_t height, py::ssize_t width) {
  std::vector<py::ssize_t> shape = {height, width};
  if (HasThreeChannels(output)) {
    shape.push_back(3);
  }
  return py::array_t<float>(shape);
}

/// Arrays by name, kept alive while they are in use.
using Arrays = std::map<std::string, py::array>;

Arrays ArraysOf(const py::dict& images) {
  Arrays arrays;
  for (const auto& [name, value] : images) {
    if (!py::isinstance<py::str>(name)) {
      throw py::type_error("names of images must be strings");
    }
    if (value.is_none()) {
      continue;
    }
    if (!py::isinstance<py::array>(value)) {
      throw py::type_error(fmt::format("image '{}' is a {}, expected a NumPy array",
                                       name.cast<std::string>(),
                                       std::string(py::str(py::type::of(value).attr("__name__")))));
    }
    arrays[name.cast<std::string>()] = py::reinterpret_borrow<py::array>(value);
  }
  return arrays;
}

class PyDenoiser {
 public:
  PyDenoiser(const std::string& preset, int threads, const std::string& device,
             const py::kwargs& settings) {
    Check(device_.Create(threads, device.c_str()));
    Check(denoiser_.Create(device_, preset.c_str()));
    Set(settings);
  }

  void Set(const py::kwargs& settings) {
    const std::unique_lock<std::mutex> lock = Use();
    for (const auto& [name, value] : settings) {
      Check(denoiser_.Set(name.cast<std::string>().c_str(), TextOf(value)));
    }
  }
  void SetPreset(const std::string& preset) {
    const std::unique_lock<std::mutex> lock = Use();
    Check(denoiser_.SetPreset(preset.c_str()));
  }
  py::dict Settings() {
    const std::unique_lock<std::mutex> lock = Use();
    py::dict settings;
    for (size_t i = 0; i < stillray_parameter_count(); ++i) {
      stillray_parameter p = STILLRAY_PARAMETER_INIT;
      stillray_parameter_at(i, &p);
      std::string value;
      Check(denoiser_.Get(p.name, &value));
      settings[p.name] = value;
    }
    return settings;
  }
  int threads() const { return device_.threads(); }
  std::string device() const { return device_.description(); }
  std::vector<std::string> Outputs() {
    const std::unique_lock<std::mutex> lock = Use();
    return denoiser_.OutputNames();
  }
  py::dict Statistics() {
    const std::unique_lock<std::mutex> lock = Use();
    stillray_statistics s = STILLRAY_STATISTICS_INIT;
    Check(denoiser_.GetStatistics(&s));
    return py::dict("non_finite"_a = s.non_finite, "negative"_a = s.negative,
                    "bad_guides"_a = s.bad_guides, "memory_bytes"_a = s.memory_bytes,
                    "filter_ms"_a = s.filter_ms);
  }
  void Reset() {
    const std::unique_lock<std::mutex> lock = Use();
    Check(denoiser_.Reset());
  }
  py::bytes SaveHistory() {
    const std::unique_lock<std::mutex> lock = Use();
    std::vector<uint8_t> bytes;
    Check(denoiser_.SaveHistory(&bytes));
    return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  void RestoreHistory(const py::bytes& history) {
    const std::unique_lock<std::mutex> lock = Use();
    const std::string_view bytes = history;
    Check({stillray_denoiser_restore_history(denoiser_.handle(), bytes.data(), bytes.size()),
           stillray_error_message(denoiser_.handle())});
  }

  py::object Denoise(const py::dict& frame, const py::object& outputs, const py::object& out,
                     const std::pair<float, float>& jitter, const py::object& progress,
                     float focal_pixels) {
    const std::unique_lock<std::mutex> lock = Use();
    const Arrays inputs = ArraysOf(frame);
    Arrays results = out.is_none() ? Arrays() : ArraysOf(out.cast<py::dict>());
    const std::vector<std::string> wanted = NamesOf(outputs);
    const Cleanup cleanup{this, inputs, results};
    GiveInputs(inputs, jitter, focal_pixels);
    if (!inputs.empty()) {
      const py::array& any = inputs.begin()->second;
      MakeResults(wanted, any.shape(0), any.shape(1), &results);
    }
    GiveOutputs(results);
    Run(progress, [&] { return denoiser_.Execute(); });
    return Answer(outputs, results);
  }

  void Push(const py::dict& frame, const std::pair<float, float>& jitter, const py::object& cut,
            const py::object& index, float focal_pixels) {
    const std::unique_lock<std::mutex> lock = Use();
    const Arrays inputs = ArraysOf(frame);
    const Arrays results;
    const Cleanup cleanup{this, inputs, results};
    if (!index.is_none()) {
      Check(denoiser_.SetFrameIndex(index.cast<int64_t>()));
    }
    GiveInputs(inputs, jitter, focal_pixels);
    const stillray_cut where = cut.is_none()      ? STILLRAY_CUT_FIND
                               : cut.cast<bool>() ? STILLRAY_CUT_YES
                                                  : STILLRAY_CUT_NO;
    stillray::api::Error error;
    {
      const py::gil_scoped_release release;
      error = denoiser_.Push(where);
    }
    Check(error);
  }

  void Finish() {
    const std::unique_lock<std::mutex> lock = Use();
    Check(denoiser_.Finish());
  }

  py::object Pull(const py::object& outputs, const py::object& out, const py::object& progress) {
    const std::unique_lock<std::mutex> lock = Use();
    stillray_waiting waiting = STILLRAY_WAITING_INIT;
    Check(denoiser_.GetWaiting(&waiting));
    if (waiting.ready == 0) {
      return py::none();
    }
    Arrays results = out.is_none() ? Arrays() : ArraysOf(out.cast<py::dict>());
    MakeResults(NamesOf(outputs), waiting.height, waiting.width, &results);
    const Arrays inputs;
    const Cleanup cleanup{this, inputs, results};
    GiveOutputs(results);
    Run(progress, [&] {
      bool pulled = false;
      return denoiser_.Pull(&pulled);
    });
    return Answer(outputs, results);
  }

  size_t Waiting() {
    const std::unique_lock<std::mutex> lock = Use();
    stillray_waiting waiting = STILLRAY_WAITING_INIT;
    Check(denoiser_.GetWaiting(&waiting));
    return waiting.frames;
  }

  py::dict MemoryNeed(const py::dict& frame, const std::pair<float, float>& jitter) {
    const std::unique_lock<std::mutex> lock = Use();
    const Arrays inputs = ArraysOf(frame);
    const Arrays results;
    const Cleanup cleanup{this, inputs, results};
    GiveInputs(inputs, jitter, 0);
    stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
    Check(denoiser_.GetMemoryNeed(&need));
    return py::dict("denoisers"_a = need.denoisers, "per_future"_a = need.per_future,
                    "per_frame"_a = need.per_frame, "most"_a = need.most);
  }

 private:
  void GiveInputs(const Arrays& inputs, const std::pair<float, float>& jitter, float focal_pixels) {
    Check(denoiser_.SetJitter(jitter.first, jitter.second));
    Check(denoiser_.SetFocalPixels(focal_pixels));
    for (const auto& [name, array] : inputs) {
      Check(denoiser_.SetInput(name.c_str(), Describe(name, array, false)));
    }
  }

  void GiveOutputs(const Arrays& results) {
    for (const auto& [name, array] : results) {
      Check(denoiser_.SetOutput(name.c_str(), Describe(name, array, true)));
    }
  }

  /// Makes the arrays that are wanted and not there.
  static void MakeResults(const std::vector<std::string>& wanted, py::ssize_t height,
                          py::ssize_t width, Arrays* results) {
    for (const std::string& name : wanted) {
      if (results->count(name) == 0) {
        (*results)[name] = MakeResult(name, height, width);
      }
    }
  }

  /// The result of a call: the picture, or all results by name if `outputs` are named.
  static py::object Answer(const py::object& outputs, const Arrays& results) {
    if (outputs.is_none()) {
      return results.at("colour");
    }
    py::dict answer;
    for (const auto& [name, array] : results) {
      answer[py::str(name)] = array;
    }
    return py::object(std::move(answer));
  }

  static std::string TypeName(const py::handle& object) {
    return py::str(py::type::handle_of(object).attr("__name__"));
  }

  static std::vector<std::string> NamesOf(const py::object& outputs) {
    if (outputs.is_none()) {
      return {"colour"};
    }
    try {
      if (!py::isinstance<py::str>(outputs)) {  // its letters are a sequence of texts too
        return outputs.cast<std::vector<std::string>>();
      }
    } catch (const py::cast_error&) {
    }
    throw py::type_error("outputs is a " + TypeName(outputs) +
                         ", expected a list of names, such as [\"colour\"]");
  }

  static bool AsBool(const py::object& answer) {
    try {
      return answer.cast<bool>();
    } catch (const py::cast_error&) {
      throw py::type_error("the progress function returned a " + TypeName(answer) +
                           ", expected True, False or None");
    }
  }

  /// Takes away the descriptions of arrays that may be gone after the call.
  struct Cleanup {
    PyDenoiser* owner;
    const Arrays& inputs;
    const Arrays& results;
    ~Cleanup() {
      for (const auto& [name, array] : inputs) {
        stillray_denoiser_set_input(owner->denoiser_.handle(), name.c_str(), nullptr);
      }
      for (const auto& [name, array] : results) {
        stillray_denoiser_set_output(owner->denoiser_.handle(), name.c_str(), nullptr);
      }
    }
  };

  /// Other Python threads run while a frame is denoised; this denoiser is not theirs meanwhile.
  std::unique_lock<std::mutex> Use() {
    std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) {
      throw ApiError("this denoiser is at work on a frame: wait for it, or use one per thread");
    }
    return lock;
  }

  /// Runs `work` on the denoiser without the interpreter's lock.
  template <typename Work>
  void Run(const py::object& progress, const Work& work) {
    std::exception_ptr raised;
    if (progress.is_none()) {
      Check(denoiser_.SetProgress(nullptr));
    } else {
      Check(denoiser_.SetProgress([&](double fraction) {
        const py::gil_scoped_acquire gil;
        try {
          const py::object answer = progress(fraction);
          return answer.is_none() || AsBool(answer);
        } catch (...) {
          raised = std::current_exception();
          return false;
        }
      }));
    }
    stillray::api::Error error;
    {
      const py::gil_scoped_release release;
      error = work();
    }
    Check(denoiser_.SetProgress(nullptr));
    if (raised) {
      std::rethrow_exception(raised);
    }
    Check(error);
    const std::string warning = denoiser_.Warning();
    if (!warning.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, warning.c_str(), 1) != 0) {
      throw py::error_already_set();  // the program has made warnings errors
    }
  }

  std::mutex mutex_;
  stillray::api::Device device_;
  stillray::api::Denoiser denoiser_;
};

std::vector<stillray_parameter> ListParameters() {
  std::vector<stillray_parameter> parameters(stillray_parameter_count(), STILLRAY_PARAMETER_INIT);
  for (size_t i = 0; i < parameters.size(); ++i) {
    stillray_parameter_at(i, &parameters[i]);
  }
  return parameters;
}

std::vector<std::string> ListPresets() {
  std::vector<std::string> presets;
  for (size_t i = 0; i < stillray_preset_count(); ++i) {
    presets.emplace_back(stillray_preset_name(i));
  }
  return presets;
}

py::dict ListInputs() {
  py::dict inputs;
  for (size_t i = 0; i < stillray_input_count(); ++i) {
    stillray_input_info info = STILLRAY_INPUT_INFO_INIT;
    stillray_input_at(i, &info);
    inputs[info.name] =
        fmt::format("{} channel{}. {}", info.channels, info.channels == 1 ? "" : "s", info.help);
  }
  return inputs;
}

/// 16 numbers, or 4 rows of 4, row by row.
void ReadMatrix(const py::dict& camera, const char* key, double* to) {
  if (!camera.contains(key)) {
    throw py::value_error(fmt::format("the camera has no '{}', expected 16 numbers", key));
  }
  using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto numbers = camera[key].cast<Numbers>();
  if (numbers.size() != 16) {
    throw py::value_error(
        fmt::format("'{}' of the camera has {} numbers, expected 16", key, numbers.size()));
  }
  std::copy_n(numbers.data(), 16, to);
}

stillray_camera CameraOf(const py::dict& from) {
  stillray_camera camera;
  ReadMatrix(from, "world_to_camera", camera.world_to_camera);
  ReadMatrix(from, "projection", camera.projection);
  return camera;
}

py::dict ReflectionsFromHits(const py::dict& frame, const py::array& hit_distance,
                             const py::dict& camera, const py::dict& previous_camera) {
  const Arrays inputs = ArraysOf(frame);
  if (inputs.count("depth") == 0) {
    throw py::value_error("image 'depth' is not given");
  }
  std::map<std::string, stillray_image> images;
  for (const char* name : {"depth", "roughness", "normal", "id"}) {
    if (const auto at = inputs.find(name); at != inputs.end()) {
      images[name] = Describe(name, at->second, false);
    }
  }
  images["hit_distance"] = Describe("hit_distance", hit_distance, false);
  const py::array& depth = inputs.at("depth");
  const py::array_t<float> image_depth({depth.shape(0), depth.shape(1)});
  const py::array_t<float> image_motion({depth.shape(0), depth.shape(1), py::ssize_t{2}});
  images["reflection_depth"] = Describe("reflection_depth", image_depth, true);
  images["reflection_motion"] = Describe("reflection_motion", image_motion, true);
  const auto find = [&](const char* name) {
    const auto at = images.find(name);
    return at == images.end() ? nullptr : &at->second;
  };
  const stillray_camera now = CameraOf(camera);
  const stillray_camera before = CameraOf(previous_camera);
  stillray_hits hits = STILLRAY_HITS_INIT;
  hits.depth = find("depth");
  hits.hit_distance = find("hit_distance");
  hits.roughness = find("roughness");
  hits.normal = find("normal");
  hits.id = find("id");
  hits.camera = &now;
  hits.previous_camera = &before;
  hits.reflection_depth = find("reflection_depth");
  hits.reflection_motion = find("reflection_motion");
  const stillray_error code = stillray_reflections_from_hits(&hits);
  Check({code, code == STILLRAY_OK ? "" : stillray_error_message(nullptr)});
  return py::dict("reflection_depth"_a = image_depth, "reflection_motion"_a = image_motion);
}

const char* TypeName(const stillray_parameter& p) {
  constexpr const char* kNames[] = {"float", "int", "flag", "choice", "steps"};
  return kNames[p.type];
}

void BindParameter(py::module_& m) {
  using P = stillray_parameter;
  py::class_<P>(m, "Parameter", "One setting of a denoiser.")
      .def_property_readonly("name", [](const P& p) { return p.name; })
      .def_property_readonly(
          "help", [](const P& p) { return p.help; }, "one sentence")
      .def_property_readonly(
          "group", [](const P& p) { return p.group; }, "the stage that reads it")
      .def_property_readonly(
          "unit", [](const P& p) { return p.unit; }, "'' if it has none")
      .def_property_readonly("type", &TypeName, "'float', 'int', 'flag', 'choice' or 'steps'")
      .def_property_readonly("min", [](const P& p) { return p.min; })
      .def_property_readonly("max", [](const P& p) { return p.max; })
      .def_property_readonly(
          "default", [](const P& p) { return p.default_value; }, "as text")
      .def_property_readonly(
          "choices",
          [](const P& p) {
            return std::vector<std::string>(p.choices, p.choices + p.choice_count);
          },
          "names, if type is 'choice'")
      .def("__repr__",
           [](const P& p) { return fmt::format("<Parameter {}={}>", p.name, p.default_value); })
      .attr("__module__") = "stillray";
}

void BindDenoiser(py::module_& m) {
  py::class_<PyDenoiser> denoiser(
      m, "Denoiser",
      "Denoises one sequence, frame by frame, and holds its history.\n\n"
      "Denoiser(preset='default', threads=0, device='cpu', **settings)\n\n"
      "    preset: one of stillray.presets()\n"
      "    threads: 0 for one per processor; the picture is the same for any number\n"
      "    device: 'cpu', 'vulkan', 'vulkan:N', or 'auto': a GPU where there is one, else the CPU\n"
      "    settings: see stillray.parameters(), such as alpha_min=0.05, steps=[1, 2, 4],\n"
      "        antialias='off'\n\n"
      "Other Python threads run while a frame is denoised. One denoiser works on one frame at a\n"
      "time; use one per thread and sequence.");
  denoiser.attr("__module__") = "stillray";
  denoiser
      .def(py::init<const std::string&, int, const std::string&, const py::kwargs&>(),
           "preset"_a = "default", "threads"_a = 0, "device"_a = "cpu")
      .def("set", &PyDenoiser::Set,
           "Changes settings from the next frame on, as in the constructor. Settings that\n"
           "contradict each other are reported by denoise().")
      .def("set_preset", &PyDenoiser::SetPreset, "preset"_a, "Sets all settings of a preset.")
      .def_property_readonly("settings", &PyDenoiser::Settings, "All settings, as text.")
      .def_property_readonly("threads", &PyDenoiser::threads, "Number of threads.")
      .def_property_readonly("device", &PyDenoiser::device,
                             "'cpu', or choice, name and driver of another device.")
      .def_property_readonly("outputs", &PyDenoiser::Outputs,
                             "Names of the results that denoise() can give with these settings.")
      .def_property_readonly(
          "statistics", &PyDenoiser::Statistics,
          "Of the last frame: values of light that were 'non_finite' or 'negative' and were\n"
          "treated as missing, pixels with 'bad_guides', 'memory_bytes', 'filter_ms'.")
      .def(
          "denoise", &PyDenoiser::Denoise, "frame"_a, "outputs"_a = py::none(),
          "out"_a = py::none(), "jitter"_a = std::pair(0.0f, 0.0f), "progress"_a = py::none(),
          "focal_pixels"_a = 0.0f,
          "Denoises the next frame of the sequence.\n\n"
          "    frame: arrays by name, see stillray.inputs(). Light is needed (one or more of\n"
          "        'direct_diffuse', ...), and 'motion' from the second frame on, unless the\n"
          "        settings follow none. 'depth', 'normal' and 'albedo' keep edges and textures\n"
          "        sharp. float32 or float16, (height, width) or (height, width, channels), any\n"
          "        strides: nothing is copied.\n"
          "    outputs: names of the results to return, see the property outputs;\n"
          "        'variance' and 'history_length' steer adaptive samplers\n"
          "    out: arrays by name to write results to; they may be the frame's own\n"
          "    jitter: all rays went through pixel (x, y) at x + 0.5 + jitter[0],\n"
          "        y + 0.5 + jitter[1]; other than (0, 0) it turns antialiasing in time on\n"
          "    progress: called with 0..1; return False to cancel (raises stillray.Cancelled)\n"
          "    focal_pixels: width / (2 tan(horizontal angle of view / 2)), which\n"
          "        depth_weight='position' needs\n\n"
          "Returns the picture, float32 of (height, width, 3), or, if outputs is given, all\n"
          "results by name. A frame of another size restarts the history.\n\n"
          "Raises ValueError naming the image or setting that is wrong (history is then\n"
          "unchanged), TypeError for other types of arrays. Warns (RuntimeWarning) of images that\n"
          "say nothing, such as normals that are all zero.")
      .def(
          "push", &PyDenoiser::Push, "frame"_a, "jitter"_a = std::pair(0.0f, 0.0f),
          "cut"_a = py::none(), "index"_a = py::none(), "focal_pixels"_a = 0.0f,
          "Appends a frame to a sequence that is denoised with light of later frames too; its\n"
          "arrays are copied. denoise_sequence() pushes and pulls by itself.\n\n"
          "    frame, jitter, focal_pixels: as for denoise(); besides 'next_motion', pixels: the\n"
          "        point seen at p stands at p + next_motion(p) one frame later (else it is found\n"
          "        from the next frame's motion)\n"
          "    cut: True: the frame begins a shot; False: it does not; None: found by comparing\n"
          "        surfaces\n"
          "    index: number of the frame; counts up from 0 by itself\n\n"
          "Raises ValueError as denoise(); the sequence is then unchanged.")
      .def("finish", &PyDenoiser::Finish,
           "The sequence ends with the last frame that was pushed: all frames are ready.")
      .def("pull", &PyDenoiser::Pull, "outputs"_a = py::none(), "out"_a = py::none(),
           "progress"_a = py::none(),
           "Finishes the next frame of those that were pushed. Frames come in blocks of 16, each\n"
           "ready once 16 frames behind it are pushed or the sequence is finished.\n\n"
           "    outputs, out, progress: as for denoise(); after cancelling, another call does the\n"
           "        work again\n\n"
           "Returns None if no frame is ready, else as denoise().")
      .def_property_readonly("waiting", &PyDenoiser::Waiting,
                             "Number of frames that were pushed and not yet pulled.")
      .def(
          "memory_need", &PyDenoiser::MemoryNeed, "frame"_a, "jitter"_a = std::pair(0.0f, 0.0f),
          "Bytes that a sequence of pushed frames like this one takes at most ('most'), in parts:\n"
          "'denoisers', 32 times 'per_frame', 16 times 'per_future'. Values do not matter.")
      .def("reset", &PyDenoiser::Reset,
           "Forgets all history, as after a cut, and all frames that wait.")
      .def("save_history", &PyDenoiser::SaveHistory,
           "The whole history, to continue later with the same bits.")
      .def("restore_history", &PyDenoiser::RestoreHistory, "history"_a,
           "Continues from save_history(). Raises stillray.Error if the bytes are damaged or of\n"
           "other settings; history is then unchanged.");
}

}  // namespace

PYBIND11_MODULE(_stillray, m) {
  m.doc() = "The compiled part of stillray.";
  m.attr("__version__") = stillray_version();
  // Never released: the interpreter may be gone when statics are.
  static auto& error = *new py::exception<ApiError>(m, "Error", PyExc_RuntimeError);
  static auto& cancelled = *new py::exception<CancelledError>(m, "Cancelled", error.ptr());
  error.attr("__module__") = "stillray";
  cancelled.attr("__module__") = "stillray";
  error.attr("__doc__") = "What has no counterpart among Python's own exceptions.";
  cancelled.attr("__doc__") = "Cancelled by the progress function.";
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) {
        std::rethrow_exception(p);
      }
    } catch (const CancelledError& e) {
      cancelled(e.what());
    } catch (const ApiError& e) {
      error(e.what());
    }
  });
  BindParameter(m);
  BindDenoiser(m);
  m.def("parameters", &ListParameters, "All settings, in the order of the documentation.");
  m.def("presets", &ListPresets, "Names of the presets.");
  m.def("_setting_text", &TextOf, "A setting as text.");
  m.def("inputs", &ListInputs, "The images that a frame may have: what each means, by name.");
  m.def("reflections_from_hits", &ReflectionsFromHits, "frame"_a, "hit_distance"_a, "camera"_a,
        "previous_camera"_a,
        "Guides of what mirrors show, from the length of reflected rays.\n\n"
        "    frame: arrays by name: 'depth', and, where known, 'roughness' (else neighbours must\n"
        "        agree), 'normal' and 'id'; others are not used\n"
        "    hit_distance: (height, width), from the first surface to what the ray met, in the\n"
        "        unit of depth; >= 1e9 and infinity: the sky; 0, negative, NaN: not known\n"
        "    camera, previous_camera: 'world_to_camera' and 'projection', 16 numbers each, row\n"
        "        by row, or 4 x 4, as in the file of cameras (docs/cameras.md); other keys are\n"
        "        not used\n\n"
        "Returns {'reflection_depth', 'reflection_motion'}, to add to the frame. Raises\n"
        "ValueError naming the image or the camera that is wrong.");
}
