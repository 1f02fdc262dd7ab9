"""An exemplar's frames under each other on one strip, so that a place there is a place in space and time.

A picture is a film of one page. Of a video every page is a frame, and texture lives on from page to page:

    onward(s) = s + v(s) + one page,

where v is the exemplar's own motion, smooth in space and time: what drifts is followed, so that only the flow that is
asked for is seen as motion, and what else changes is how the exemplar lives (thesis 7.3, 8.1.1). Where a page has no
next one, or the motion leaves the frame, texture stays as it is; `left` says for how many frames it does not have to.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from flow.animation.carrying import blurred
from flow.animation.film.drift import drift
from flow.animation.film.joints import joints
from flow.animation.film.reading import Reading
from flow.warps import pixel_coordinates, warp
from kwatra import Exemplar, InputError, direction_dependence, element_size, place_dependence
from kwatra.base import mean, over_channels
from kwatra.elements import STRAIGHT, anisotropy, runs_along
from kwatra.pieces import Hidden
from kwatra.source import look_up
from kwatra.terms.stay import SCENE

_DIRECTED = 0.21
"""Of pictures with less `direction_dependence` copies may turn. Gravel, grass, rocks, terrazzo, tomatoes, radishes and
made stones have 0 to .16; plaster, chainmail, nuts and words .22 to .31, bricks, tiles and cloth more."""

_AS_ONE = 0.25
"""Copies turn as one over so many sizes of an element: elements turn, and are not bent. Not tuned."""

_GAP = 16
"""Rows between pages, at least, and the drift's largest step besides: what flows beyond a page ends in no other one."""

_NEXT = 1
"""Places are told apart by what they show so many frames on and before, too."""

_DYNAMICS = 0.5
"""What each of these counts beside all colors' 1."""

_LONGEST = 0.9
"""The longest memory that is believed: of clips that hardly change."""

_FINE = 3.0
"""Grain is what differs from its surroundings, over so many px."""

_GRAIN = 0.2
"""What grain counts, brought to the deviation of the mean color. Drops of a fountain lie in squares with 0; with 1 they
are lost, since blocks without them fit as well."""


@dataclass(frozen=True, eq=False)
class Film:
    """An exemplar's frames on a strip.

    strip: all pages as one picture. pages: their number; pitch: rows from one to the next. motion (2, pages * pitch,
    W): the exemplar's own, x first, in px per frame, forward; None for a picture. step: 1, or -1 where time runs
    backward. also: maps of the exemplar on a strip of their own, which decide nothing; None where there are none.
    scene: whether what is seen depends on the place in its frame. turning: over how many px copies turn as one with
    the flow; 0 where they keep the exemplar's directions. placed (2, rows, W): of a picture that was grown
    (`flow.animation.film.growing`) which pixels of the exemplar's own canvas it shows, or is near to where it shows
    what is between them, row first; None of others.
    """

    strip: Exemplar
    pages: int
    pitch: int
    motion: Tensor | None = None
    step: int = 1
    also: Exemplar | None = None
    scene: bool = False
    turning: float = 0.0
    placed: Tensor | None = None

    @classmethod
    def of(cls, exemplar: Exemplar, also: Exemplar | None = None, turn: bool | None = None) -> "Film":
        """The film of an exemplar of pictures or videos; of videos, texture that is masked in any frame is not used.

        also: maps of each of its images or videos, an exemplar made as it was. turn: whether copies may turn; None:
        where an exemplar of pictures prefers no direction.
        """
        film = cls._of(exemplar)
        if turn and film.motion is not None:
            raise InputError(
                "texture is to turn with the flow, but that of a video keeps its directions; leave turn out"
            )
        if film.motion is None and (turn or (turn is None and direction_dependence(film.strip) < _DIRECTED)):
            film = replace(film, turning=_AS_ONE * element_size(film.strip))
        if also is None:
            return film
        also = also.to(exemplar.canvas.device)
        if also.shape != exemplar.shape or not torch.equal(also.owner, exemplar.owner):
            raise InputError(
                f"maps lie on {also.shape} but the exemplar on {exemplar.shape}; a map has its image's size"
            )
        maps = also.canvas if len(also.shape) == 2 else _flat(also.canvas, film.pitch - also.shape[1])
        return replace(film, also=replace(film.strip, canvas=maps, weights=also.weights))

    @classmethod
    def _of(cls, exemplar: Exemplar) -> "Film":
        if len(exemplar.shape) == 2:
            return cls(exemplar, 1, exemplar.shape[0])
        if exemplar.shape[0] == 1:
            return cls(
                replace(exemplar, canvas=exemplar.canvas[:, 0], owner=exemplar.owner[0], origin=exemplar.origin[:, 0]),
                1,
                exemplar.shape[1],
            )
        motion = drift(exemplar)
        gap = _GAP + 2 * int(motion.abs().max().ceil())
        whole = (exemplar.owner == exemplar.owner[0]).all(0)
        owner = torch.where(whole, exemplar.owner, -1.0)
        number = torch.arange(len(owner), device=owner.device).view(-1, 1, 1)
        owner = torch.where(owner >= 0, owner + number * (owner.max() + 1), -1.0)
        flat = Exemplar(
            _flat(exemplar.canvas, gap), _flat(owner[None], gap, -1.0)[0], _flat(exemplar.origin, gap), exemplar.weights
        )
        scene = place_dependence(exemplar) >= SCENE
        return cls(flat, len(owner), exemplar.shape[1] + gap, _flat(motion, gap), scene=scene)

    def to(self, device: torch.device | str) -> "Film":
        """The same film on another device."""
        motion, placed = (None if part is None else part.to(device) for part in (self.motion, self.placed))
        also = self.also and self.also.to(device)
        return replace(self, strip=self.strip.to(device), motion=motion, also=also, placed=placed)

    @property
    def backward(self) -> "Film":
        """The same film, in which time runs backward."""
        return self if self.motion is None else replace(self, step=-self.step)

    @cached_property
    def read(self) -> Reading:
        """The strip between its pixels, bilinearly."""
        return Reading(self.strip, "bilinear")

    @cached_property
    def hidden(self) -> Hidden | None:
        """Where gaps between a picture's elements hide seams; None where they do nowhere, and of videos."""
        return joints(self.strip) if self.motion is None else None

    @cached_property
    def along(self) -> int | None:
        """The axis, 0 down and 1 to the right, along which a picture runs that has no gaps and keeps its directions.

        None of others, and of videos.
        """
        if self.motion is not None or self.turning or self.hidden is not None:
            return None
        return runs_along(anisotropy(self.strip), STRAIGHT)

    def onward(self, source: Tensor) -> Tensor:
        """Where texture at source coordinates (2, *S) is read a frame later; the same where it cannot live on."""
        if self.motion is None:
            return source
        velocity = warp(self.motion, source, "bilinear")
        moved = source + self.step * velocity
        moved[1] += self.step * self.pitch
        return torch.where(self.read.usable(moved), moved, source)

    @cached_property
    def left(self) -> Tensor:
        """For how many frames texture at every place of the strip can live on, (rows, W); inf in a picture."""
        rows, columns = self.strip.shape
        if self.motion is None:
            return torch.full((rows, columns), torch.inf, dtype=torch.float32, device=self.strip.canvas.device)
        left = torch.zeros(rows, columns, dtype=torch.float32, device=self.strip.canvas.device)
        places = pixel_coordinates((rows, columns), left.device)
        order = range(self.pages - 2, -1, -1) if self.step > 0 else range(1, self.pages)
        for page in order:
            part = slice(page * self.pitch, (page + 1) * self.pitch)
            here = places[:, part]
            there = self.onward(here)
            x, y = there.round().long()
            left[part] = torch.where((there != here).any(0), 1 + left[y.clamp(0, rows - 1), x.clamp(0, columns - 1)], 0)
        return left

    @cached_property
    def _gray(self) -> Tensor:
        """The strip's mean color, (1, rows, W)."""
        return over_channels(self.read.continued * self.strip.share)[None]

    @cached_property
    def grain(self) -> Tensor | None:
        """How grainy a video is at every place of the strip, (rows, W): the mean difference from its surroundings, with
        the deviation of the mean color. None of a picture."""
        return None if self.motion is None else _grain(self._gray, self.strip.owner >= 0)[0]

    @cached_property
    def described(self) -> Exemplar:
        """The strip with channels that tell its dynamics, the mean color in the next frame and in the one before, and
        its grain: of texture that never repeats the mean fits best, so how grainy it is has to be told.
        """
        if self.grain is None:
            return self.strip
        places = pixel_coordinates(self.strip.shape, self.strip.canvas.device)
        gray, more = self._gray, []
        for film in (self, self.backward):
            there = places
            for _ in range(_NEXT):
                there = film.onward(there)
            more.append(warp(gray, there, "bilinear"))
        weights = (
            torch.tensor([_DYNAMICS, _DYNAMICS, _GRAIN], dtype=torch.float32, device=gray.device)
            * self.strip.weights.sum()
        )
        canvas = torch.cat([self.strip.canvas, *more, self.grain[None]])
        return replace(self.strip, canvas=canvas, weights=torch.cat([self.strip.weights, weights]))

    @cached_property
    def memory(self) -> float:
        """What a frame keeps of the one before, 0 to 0.9: 1 less its change, its own motion followed, in units of that
        between frames at unrelated times."""
        frames = self.strip.canvas.unflatten(1, (self.pages, self.pitch))
        known = (self.strip.owner >= 0).view(self.pages, self.pitch, -1).all(0)
        if self.motion is None or not bool(known.any()):
            return 0.0
        places = pixel_coordinates(self.strip.shape, self.strip.canvas.device)
        before = places[:, : -self.pitch].unflatten(1, (self.pages - 1, self.pitch))[:, :, known].flatten(1)
        after = replace(self, step=1).onward(before)
        lives = (after != before).any(0)
        change = over_channels((self.read(after) - self.read(before))[:, lives].square())
        spread = over_channels(frames[:, :, known].var(1))
        unrelated = 2 * mean(spread) if bool(lives.any()) else torch.zeros((), dtype=torch.float32)
        return float((1 - mean(change) / unrelated).clamp(0, _LONGEST)) if float(unrelated) > 0 else 0.0

    def spread(self, count: int) -> list[int]:
        """Up to so many pages, evenly spread, of those from which texture can live on for a while."""
        first, last = self.starts
        numbers = torch.linspace(first, last, min(count, last - first + 1), dtype=torch.float32).round().long()
        return [int(number) for number in numbers]

    @property
    def starts(self) -> tuple[int, int]:
        """The first and the last page from which texture can live on for half of the film, or longer."""
        half = (self.pages - 1) // 2
        return (0, half) if self.step > 0 else (self.pages - 1 - half, self.pages - 1)

    def rows(self, pages: list[int]) -> Tensor:
        """The rows of the strip that some pages have."""
        row = torch.arange(self.pitch, device=self.strip.canvas.device)
        return torch.cat([page * self.pitch + row for page in pages])

    def cut(self, exemplar: Exemplar, pages: list[int]) -> Exemplar:
        """The strip, or the described one, with some pages alone, one under the other."""
        if self.pages == 1:
            return exemplar
        rows = self.rows(pages)
        return replace(
            exemplar, canvas=exemplar.canvas[:, rows], owner=exemplar.owner[rows], origin=exemplar.origin[:, rows]
        )

    def uncut(self, where: Tensor, pages: list[int]) -> Tensor:
        """Places (2, *S), row first, of the whole strip from those of a strip of some pages alone."""
        if self.pages == 1:
            return where
        number = torch.tensor(pages, device=where.device)[where[0] // self.pitch]
        return torch.stack([number * self.pitch + where[0] % self.pitch, where[1]])

    def middle(self, shape: tuple[int, int]) -> Tensor:
        """The source coordinates (2, H, W) of a frame of `shape` in the middle of a picture."""
        corner = [(there - here) // 2 for there, here in zip(self.strip.shape, shape, strict=True)]
        places = pixel_coordinates(shape, self.strip.canvas.device)
        return places + torch.tensor(corner[::-1], device=places.device).view(2, 1, 1)

    def where(self, pixels: Tensor) -> Tensor:
        """The places on the exemplar's own canvas of pixels of the strip (2, *S), row first: frame, row and column."""
        if self.placed is not None:
            pixels = look_up(self.placed, pixels)
        if len(self.strip.origin) == 3:
            return pixels
        return torch.stack([pixels[0] // self.pitch, pixels[0] % self.pitch, pixels[1]])


def _grain(gray: Tensor, known: Tensor) -> Tensor:
    """How much a picture (1, H, W) differs from its surroundings where it is known (H, W), with its own deviation."""
    grain = blurred((gray - blurred(gray, known, _FINE)).abs(), known, _FINE)
    return grain * (_deviation(gray[:, known]) / _deviation(grain[:, known]).clamp(min=1e-6))


def _deviation(values: Tensor) -> Tensor:
    return mean((values - mean(values)).square()).sqrt()


def _flat(values: Tensor, gap: int, empty: float = 0.0) -> Tensor:
    """Frames (C, T, H, W) under each other, each with a gap below: (C, T * (H + gap), W)."""
    return torch.nn.functional.pad(values, (0, 0, 0, gap), value=empty).flatten(1, 2)
