// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The HTML text of a report.
#pragma once

#include <string>
#include <vector>

#include "quality/render_log.h"
#include "quality/report.h"
#include "quality/report_measure.h"
#include "stillray/status.h"

namespace stillray::report {

struct PageContent {
  std::string name;        ///< of the folder or the sequence, without parent folders
  std::string source;      ///< the origin of the page's data, as stated at its end
  bool of_folder = false;  ///< of stillray render, else sequences of any origin
  bool has_log = false;
  RenderLog log;
  int frames_found = 0;
  int zoom_width = 0;
  Measurements measurements;
  std::vector<std::string> notes;
};

/// "cornell, svgf" from render.json, else the name of the folder or sequence.
std::string PageTitle(const PageContent& content);

/// Escapes text for use between HTML tags and in quoted attributes. Bytes that are not UTF-8 become
/// U+FFFD.
std::string EscapeHtml(const std::string& text);

/// The page: a fixed template, style sheet and script, and two blocks of JSON that the script
/// reads. Text from files occurs only in the JSON and in the title; the script inserts it as text
/// nodes, never as markup.
std::string MakePage(const PageContent& content);

}  // namespace stillray::report
