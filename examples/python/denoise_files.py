# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Equivalent to `stillray denoise IN -o OUT --window both --passes`.

    python3 denoise_files.py IN_FOLDER OUT_FOLDER
"""

import sys

import stillray

frames = stillray.denoise_files(sys.argv[1], sys.argv[2], window="both", passes=True)
for frame in frames:
    print(f"frame {frame['frame']}: {frame['denoise_ms']:.0f} ms {frame['note']}")
