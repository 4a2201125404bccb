// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report_page.h"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "core/base64.h"
#include "core/check.h"
#include "quality/heat_map.h"
#include "quality/report_times.h"

namespace stillray::report {

/// Generated at build time from the files beside this one.
extern const char kReportTemplate[];
extern const char kReportStyle[];
extern const char kReportViewsScript[];
extern const char kReportViewerScript[];
extern const char kReportPlotsScript[];
extern const char kReportPageScript[];

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity; the page's script parses these words.
Json Number(double value) {
  if (std::isnan(value)) {
    return nullptr;
  }
  return std::isinf(value) ? Json(value > 0 ? "inf" : "-inf") : Json(value);
}

template <typename T>
Json OptionalNumber(const std::optional<T>& value) {
  return value ? Number(static_cast<double>(*value)) : Json(nullptr);
}

/// One metric in the page's list.
struct MetricField {
  const char* name;
  double ImageMetrics::*member;
};
constexpr MetricField kMetricFields[] = {
    {"psnr", &ImageMetrics::psnr},
    {"ssim", &ImageMetrics::ssim},
    {"flip", &ImageMetrics::flip},
    {"rel_mse", &ImageMetrics::rel_mse},
    {"hdr_flip", &ImageMetrics::hdr_flip},
    {"brightness", &ImageMetrics::brightness},
    {"bright_specks", &ImageMetrics::bright_specks},
    {"dark_specks", &ImageMetrics::dark_specks},
    {"worst_share", &ImageMetrics::worst_share},
    {"brightness_lowest", &ImageMetrics::brightness_lowest},
    {"brightness_highest", &ImageMetrics::brightness_highest},
};

/// The images of the page: base64 texts, referred to by index.
class PictureList {
 public:
  Json Add(const std::string& png) {
    if (png.empty()) {
      return nullptr;
    }
    text_ += count_ == 0 ? "\"" : ",\n\"";
    AppendBase64(png, &text_);
    text_ += "\"";
    return count_++;
  }
  std::string TakeJson() {
    text_ += "]";
    return std::move(text_);
  }

 private:
  std::string text_ = "[";
  int count_ = 0;
};

const char* SourceName(Source source) {
  return source == kLinear ? "linear" : "display";
}

Json FramesJson(const PageContent& content, PictureList* pictures) {
  Json frames = Json::array();
  for (const ShownFrame& frame : content.measurements.shown) {
    Json entry = {{"number", frame.number}, {"seconds", nullptr}};
    for (const RenderLogFrame& logged : content.log.frames) {
      if (logged.number == frame.number) {
        entry["seconds"] = OptionalNumber(logged.seconds);
      }
    }
    Json views = Json::object();
    for (size_t v = 0; v < kViewCount; ++v) {
      const ShownView& view = frame.views[v];
      if (!view.png.empty()) {
        views[kViewNames[v]] = {{"picture", pictures->Add(view.png)},
                                {"flip", pictures->Add(view.maps[kFlipMap])},
                                {"rel_se", pictures->Add(view.maps[kRelativeSquaredErrorMap])},
                                {"map_source", SourceName(view.map_source)}};
      }
    }
    entry["views"] = views;
    frames.push_back(entry);
  }
  return frames;
}

/// Frames without a temporal error are excluded from the mean.
void AddTemporalError(const Measurements& measurements, size_t source, size_t view, Json* mean,
                      Json* values) {
  int count = 0;
  double sum = 0;
  Json series = Json::array();
  for (const MeasuredFrame& frame : measurements.measured) {
    const std::optional<double>& error = frame.temporal_error[source][view];
    series.push_back(OptionalNumber(error));
    count += error.has_value();
    sum += error.value_or(0.0);
  }
  (*mean)["temporal_error"] = count > 0 ? Number(sum / count) : Json(nullptr);
  (*values)["temporal_error"] = std::move(series);
}

/// The mean is the slope over all frames, in which frames of more change have more weight.
void AddLightChange(const Measurements& measurements, size_t source, size_t view, Json* mean,
                    Json* values) {
  LightChange sum;
  Json series = Json::array();
  for (const MeasuredFrame& frame : measurements.measured) {
    const std::optional<LightChange>& change = frame.light_change[source][view];
    series.push_back(change ? Number(change->Share()) : Json(nullptr));
    sum.product += change ? change->product : 0.0;
    sum.square += change ? change->square : 0.0;
  }
  (*mean)["light_change"] = Number(sum.Share());
  (*values)["light_change"] = std::move(series);
}

/// All metrics of one view on one source: values over the measured frames, and their means.
Json ViewQualityJson(const Measurements& measurements, size_t source, size_t view) {
  int count = 0;
  int64_t non_finite = 0;
  for (const MeasuredFrame& frame : measurements.measured) {
    if (const std::optional<ImageMetrics>& metrics = frame.metrics[source][view]) {
      ++count;
      non_finite += metrics->non_finite;
    }
  }
  if (count == 0) {
    return nullptr;
  }
  Json mean = {{"frames", count}, {"non_finite", non_finite}};
  Json values = Json::object();
  for (const MetricField& field : kMetricFields) {
    double sum = 0;
    Json series = Json::array();
    for (const MeasuredFrame& frame : measurements.measured) {
      const std::optional<ImageMetrics>& metrics = frame.metrics[source][view];
      series.push_back(metrics ? Number((*metrics).*field.member) : Json(nullptr));
      sum += metrics ? (*metrics).*field.member : 0.0;
    }
    mean[field.name] = Number(sum / count);
    values[field.name] = std::move(series);
  }
  AddTemporalError(measurements, source, view, &mean, &values);
  AddLightChange(measurements, source, view, &mean, &values);
  return {{"mean", std::move(mean)}, {"values", std::move(values)}};
}

Json QualityJson(const Measurements& measurements) {
  Json sources = Json::array();
  for (const Source source : {kLinear, kDisplay}) {
    Json views = Json::object();
    for (size_t view = 0; view < kTestViewCount; ++view) {
      Json quality = ViewQualityJson(measurements, source, view);
      if (!quality.is_null()) {
        views[kViewNames[view]] = std::move(quality);
      }
    }
    if (!views.empty()) {
      sources.push_back({{"source", SourceName(source)}, {"views", std::move(views)}});
    }
  }
  Json numbers = Json::array();
  for (const MeasuredFrame& frame : measurements.measured) {
    numbers.push_back(frame.number);
  }
  return {{"frames", std::move(numbers)}, {"sources", std::move(sources)}};
}

Json StepJson(const StepTimes& step) {
  return {{"name", step.name},  {"frames", step.frames}, {"median", step.median_ms},
          {"min", step.min_ms}, {"max", step.max_ms},    {"sum", step.sum_ms},
          {"share", step.share}};
}

Json TimesJson(const std::vector<RenderLogFrame>& frames) {
  const TimeTable table = MakeTimeTable(frames);
  Json stages = Json::array();
  for (const StepTimes& stage : table.stages) {
    stages.push_back(StepJson(stage));
  }
  Json numbers = Json::array();
  Json render = Json::array();
  Json denoise = Json::array();
  for (const RenderLogFrame& frame : frames) {
    numbers.push_back(frame.number);
    render.push_back(OptionalNumber(frame.render_ms));
    denoise.push_back(OptionalNumber(frame.denoise_ms));
  }
  return {{"stages", std::move(stages)},
          {"render", table.render ? StepJson(*table.render) : Json(nullptr)},
          {"denoise", table.denoise ? StepJson(*table.denoise) : Json(nullptr)},
          {"write", table.write ? StepJson(*table.write) : Json(nullptr)},
          {"frames", std::move(numbers)},
          {"render_ms", std::move(render)},
          {"denoise_ms", std::move(denoise)}};
}

template <typename T>
Json PairsJson(const std::vector<std::pair<std::string, T>>& pairs) {
  Json list = Json::array();
  for (const auto& [name, value] : pairs) {
    list.push_back(Json::array({name, value}));
  }
  return list;
}

Json ScaleJson(const HeatScale& scale) {
  return {{"logarithmic", scale.logarithmic}, {"low", scale.low}, {"high", scale.high}};
}

Json HeatJson() {
  Json ramp = Json::array();
  for (int i = 0; i <= kNotFiniteIndex; ++i) {
    const Rgb8& c = HeatPalette()[static_cast<size_t>(i)];
    ramp.push_back(fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]));
  }
  return {{"ramp", std::move(ramp)},
          {"flip", ScaleJson(kFlipScale)},
          {"rel_se", ScaleJson(kRelativeSquaredErrorScale)}};
}

/// JSON text for a script element: no "<" can end it, no "&" or line separator can be misread.
std::string ScriptSafe(const Json& json) {
  // ASCII only, so that the page is readable under a wrong encoding; bytes that are not UTF-8
  // become U+FFFD.
  const std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&') {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe.push_back(c);
    }
  }
  return safe;
}

/// Replaces invalid UTF-8.
std::string ValidUtf8(const std::string& text) {
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace))
      .get<std::string>();
}

/// Replaces each "{{NAME}}" of the template. Inserted text is not searched again.
std::string FillTemplate(std::string_view page,
                         const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string filled;
  size_t size = page.size();
  for (const auto& value : values) {
    size += value.second.size();
  }
  filled.reserve(size);
  for (const auto& [name, value] : values) {
    const std::string marker = fmt::format("{{{{{}}}}}", name);
    const size_t at = page.find(marker);
    STILLRAY_CHECK(at != std::string_view::npos);
    filled += page.substr(0, at);
    filled += value;
    page.remove_prefix(at + marker.size());
  }
  filled += page;
  return filled;
}

}  // namespace

std::string PageTitle(const PageContent& content) {
  std::string title = content.log.scene;
  if (!content.log.preset.empty()) {
    title += (title.empty() ? "" : ", ") + content.log.preset;
  }
  return ValidUtf8(title.empty() ? content.name : title);
}

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : ValidUtf8(text)) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped.push_back(c);
    }
  }
  return escaped;
}

std::string MakePage(const PageContent& content) {
  const Measurements& measurements = content.measurements;
  PictureList pictures;
  const Json data = {{"title", PageTitle(content)},
                     {"source", content.source},
                     {"has_log", content.has_log},
                     {"version", content.log.version},
                     {"width", measurements.width},
                     {"height", measurements.height},
                     {"fps", OptionalNumber(content.log.fps)},
                     {"frames_found", content.frames_found},
                     {"zoom_width", content.zoom_width},
                     {"frames", FramesJson(content, &pictures)},
                     {"quality", QualityJson(measurements)},
                     {"times", TimesJson(content.log.frames)},
                     {"settings", PairsJson(content.log.settings)},
                     {"parameters", PairsJson(content.log.parameters)},
                     {"memory", PairsJson(content.log.memory)},
                     {"heat", HeatJson()},
                     {"notes", content.notes}};
  return FillTemplate(kReportTemplate, {{"TITLE", EscapeHtml(PageTitle(content))},
                                        {"STYLE", kReportStyle},
                                        {"DATA", ScriptSafe(data)},
                                        {"PICTURES", pictures.TakeJson()},
                                        {"VIEWS", kReportViewsScript},
                                        {"VIEWER", kReportViewerScript},
                                        {"PLOTS", kReportPlotsScript},
                                        {"SCRIPT", kReportPageScript}});
}

}  // namespace stillray::report
