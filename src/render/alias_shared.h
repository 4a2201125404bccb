// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Choice among many in constant time: Vose (1991), "A linear algorithm for generating random
// numbers with a given distribution". A number in [0, 1) picks a column of the table, then one of
// the column's two items.
#ifndef STILLRAY_RENDER_ALIAS_SHARED_H
#define STILLRAY_RENDER_ALIAS_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct AliasEntry {
  float keep;         // probability of the entry itself, given its column
  uint other;         // what the column gives otherwise
  float probability;  // of this entry, over all
  uint item;          // what the entry stands for: the table's owner knows
};

struct AliasColumn {
  uint index;
  float within;  // u again uniform in [0, 1), given the column
};

struct AliasChoice {
  uint index;
  float rest;  // u again uniform in [0, 1), given the index
};

SHARED_FN AliasColumn FindAliasColumn(uint count, float u) {
  float scaled = u * float(count);
  AliasColumn column;
  column.index = min(uint(scaled), count - 1u);
  column.within = min(scaled - float(column.index), kBelowOne);
  return column;
}

// \param entry  that of the column
SHARED_FN AliasChoice ChooseInColumn(SHARED_IN(AliasColumn) column, SHARED_IN(AliasEntry) entry) {
  AliasChoice choice;
  if (column.within < entry.keep) {
    choice.index = column.index;
    choice.rest = min(column.within / entry.keep, kBelowOne);
  } else {
    choice.index = entry.other;
    choice.rest = min((column.within - entry.keep) / (1.0f - entry.keep), kBelowOne);
  }
  return choice;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ALIAS_SHARED_H
