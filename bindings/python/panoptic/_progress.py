# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A progress bar, where tqdm is installed."""
from typing import Any, Iterable, TypeVar

T = TypeVar("T")


def progress(frames: Iterable[T], **bar: Any) -> Iterable[T]:
    """The same frames with tqdm's bar (`bar` goes to tqdm), or without one where tqdm is not installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return frames
    shown: Iterable[T] = tqdm(frames, **bar)
    return shown
