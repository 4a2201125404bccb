// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The types shared by all parts of stillray.
#pragma once

#include "stillray/frame.h"   // IWYU pragma: export
#include "stillray/image.h"   // IWYU pragma: export
#include "stillray/status.h"  // IWYU pragma: export
