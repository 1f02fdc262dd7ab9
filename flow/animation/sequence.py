"""Textures that flow: a sequence made frame by frame, for as long as one likes (thesis algorithm 3).

The first frame is ordinary synthesis. Every other one is the frame before it carried along the flow, x+, and then
optimized: its texture energy against the flow energy. Frames are carried as source coordinates (`carrying`), their
elements turned upright (`carrying.upright`) and blocks copied where the texture has worn all the same (`renewing`); so
a sequence never wears out. What is shown is the blend of these copies and x+, as the flow term has it (`term`), where
both are alike. Memory does not grow with the number of frames.

Elements of pictures that keep their directions, and are compact and apart, are drawn anew in every frame instead, each
whole, as it has been moved and bent on the mean (`kwatra.pieces.redrawn`); what was drawn is what is carried. Long ones
that a net of joints parts, bricks, are copied, and are shown with joints where copies tear them (`showing.mortar`).

Where the exemplar of a picture prefers no direction, and the flow turns what it carries more than it bends it, elements
turn with the flow and are only kept rigid; the first frame is then the middle of a larger still that takes the
exemplar's place (`film.growing`).

A picture is a video of one frame. Of a longer one texture also lives on: before it is renewed it moves on to the
video's next frame (`film`), and so does what fades below it (`showing.fading`). Where what is seen depends on the
place in its frame, the first frame keeps the places.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import torch
from torch import Tensor

from flow.animation.asked import Mask, allowed, check, film_of, frame_of
from flow.animation.carrying import SIDES, Upright, carried, entered, known_of, overlapped, tidied
from flow.animation.film import Film, grown
from flow.animation.renewing import NOWHERE, Renewal, places, places_onward
from flow.animation.settings import PRESETS, VIDEO_PRESETS, Renewing, seldom
from flow.animation.showing import Mortar, Showing
from flow.animation.state import State
from flow.fields import Field
from flow.warps import Lookup, lookup, warp
from kwatra import Exemplar, InputError, Level, Result, Settings, Stay, optimize
from kwatra.base import floats_of, generator_of, is_whole
from kwatra.pieces import cells_that_flow, redrawn
from kwatra.result import Row
from kwatra.source import look_up
from kwatra.terms.stay import STAYING

_BEGINNING = 1 << 17
"""The first frame of a video is made of frames that have about so many pixels together, and of two at least."""

_SETTLING = 4
"""Elements of a first frame are drawn so often, until they hardly move any more: of stones of 20 px a hundredth by more
than half a pixel."""

_PROJECTION = (Level(1, 16), Level(1, 8))
"""How a given first picture is brought to the exemplar: at full resolution, keeping what is texture already."""


@dataclass(frozen=True)
class Frame(Result):
    """A frame of an animation: a result, and the state that the next one follows from.

    Its image is 0 where there is no texture, and so is also (M, H, W), the maps that go along, None where there are
    none; source and where tell of its copies, not of what fades. Its one row of energies has frame, texture (mean wear
    and price of tones before renewal, beyond what is tolerated), flow (the mean of the flow term, lambda K |x - x+|^2,
    after it; both in variances of the exemplar, as in `flow.animation.renewing.renewal`) and renewed (the share of its
    pixels).
    """

    state: State
    also: Tensor | None = None


def animate(
    exemplar: Exemplar | Tensor,
    field: Field,
    shape: tuple[int, int] = (256, 256),
    *,
    frames: int | None = None,
    first: Tensor | None = None,
    mask: Mask = None,
    enter: str | None = None,
    renewing: Renewing | None = None,
    synthesis: Settings | None = None,
    seed: int = 0,
    after: State | None = None,
    also: Exemplar | Tensor | None = None,
    turn: bool | None = None,
) -> Iterator[Frame]:
    """The frames, of `shape` (H, W), of a texture that flows along a field.

    exemplar: an Exemplar, an image (C, H, W), or a video (C, T, H, W), whose texture lives on as it does there, one of
    its frames in each. frames: how many; None for no end. first: a picture (C, H, W) to begin with, brought to the
    exemplar first. mask: True where texture belongs, (H, W), or a function of the frame's number.
    enter: begin with an empty frame into which the flow carries texture from this side, one of SIDES. synthesis: how
    the first frame is made; renewing: how the others are (default: of PRESETS or VIDEO_PRESETS). after: go on after
    this state instead of beginning; the frames are the same bits as without the break. also: maps of the exemplar, of
    its size, (M, H, W) or (M, T, H, W), or an Exemplar of them made as it was; they are read, and fade, as its colors
    do, and decide nothing. turn: whether elements of pictures turn with the flow; else they keep their directions, and
    what cannot is renewed (thesis 6.2). None: they turn where the exemplar prefers no direction
    (`kwatra.direction_dependence` below .21) and the flow is nearly rigid: turns and moves, and hardly shears.

    What is synthesized at first is made on the exemplar's device; frames are carried, and given, on the CPU.

    Raises InputError for what cannot be done, at once where it can be seen at once.
    """
    if frames is not None and not is_whole(frames, 1):
        raise InputError(f"the number of frames is {frames}; give a whole number, at least 1, or None for no end")
    if enter is not None and enter not in SIDES:
        raise InputError(f"texture is to enter from {enter!r}; give one of {', '.join(SIDES)}")
    if enter is not None and first is not None:
        raise InputError("texture is to enter an empty frame, but a first frame is given; leave out one of the two")
    synthesis = synthesis or Settings()
    motion = Motion.of(exemplar, field, shape, mask, enter, renewing, synthesis, seed, after, also, turn)
    return _frames(motion, None if frames is None else int(frames), first, synthesis, after)


def _frames(
    motion: "Motion", frames: int | None, first: Tensor | None, synthesis: Settings, after: State | None
) -> Iterator[Frame]:
    state = after
    if state is None:
        frame = motion.begin(first, synthesis)
        yield frame
        state = frame.state
    for _ in count() if frames is None else range(state.number + 1, frames):
        frame = motion.step(state)
        yield frame
        state = frame.state


class Motion:
    """An exemplar's texture moving along a field: makes a first frame, and the next one of a state, on the CPU."""

    def __init__(
        self,
        film: Film,
        field: Field,
        shape: tuple[int, int],
        mask: Mask,
        enter: str | None,
        renewing: Renewing | None,
        seed: int,
    ) -> None:
        renewing = renewing or (PRESETS if film.motion is None else VIDEO_PRESETS)["default"]
        self.device, film = film.strip.canvas.device, film.to("cpu")
        self.film, self.field, self.shape, self.mask, self.enter, self.seed = film, field, shape, mask, enter, seed
        self.cells = None if film.hidden is None or film.turning else cells_that_flow(film.strip)
        if self.cells is not None:
            renewing = seldom(renewing)
        self.upright = None if self.cells is not None else Upright(film.strip, renewing.stiffness, film.turning)
        self.renewing, self.renewal = renewing, Renewal(film, shape, renewing, self.cells is not None)
        self.showing, self.mortar = Showing(film, renewing, self.renewal.wear.variance), Mortar.of(film)
        self._steady: tuple[Tensor, Lookup] | None = None
        self._flowing: Tensor | None = None
        self._everywhere = torch.ones(shape, dtype=torch.bool)

    @classmethod
    def of(
        cls,
        exemplar: Exemplar | Tensor,
        field: Field,
        shape: tuple[int, int],
        mask: Mask,
        enter: str | None,
        renewing: Renewing | None,
        synthesis: Settings,
        seed: int,
        after: State | None,
        also: Exemplar | Tensor | None,
        turn: bool | None,
    ) -> "Motion":
        """That of an exemplar as `animate` is given it; InputError for what cannot be done."""
        shape = frame_of(shape)
        film = film_of(exemplar, also, turn, field, shape)
        check(film, field, shape, mask, enter, after)
        return cls(grown(film, shape, synthesis, seed), field, shape, mask, enter, renewing, seed)

    def allowed(self, number: int) -> Tensor:
        """Where (H, W) texture may be in a frame."""
        return self._everywhere if self.mask is None else allowed(self.mask, number, self.shape).cpu()

    def begin(self, first: Tensor | None, synthesis: Settings) -> Frame:
        """Frame 0: empty if texture is to enter it, else synthesized, or a given picture brought to the exemplar."""
        inside = self.allowed(0)
        if self.enter is not None:
            inside = torch.zeros_like(inside)
            nowhere = torch.full((2, *self.shape), NOWHERE, dtype=torch.float32)
            empty = self.showing.picture(nowhere, inside) * 0
            return self._frame(State(0, nowhere, inside, empty), nowhere, {})
        if self.film.placed is not None and first is None:
            return self.shown(self.film.middle(self.shape), inside)
        start: Tensor | str = "aligned"
        if first is not None:
            start, synthesis = floats_of(first).to(self.device), replace(synthesis, levels=_PROJECTION)
        mask = None if self.mask is None else inside.to(self.device)
        pages = self.film.spread(max(_BEGINNING // (self.film.pitch * self.film.strip.shape[1]), 2))
        exemplar = self.film.cut(self.film.strip, pages).to(self.device)
        stay = [Stay(STAYING)] if self.film.scene and first is None else []
        still = optimize(exemplar, self.shape, settings=synthesis, terms=stay, start=start, mask=mask, seed=self.seed)
        source = tidied(self.film.uncut(still.where.cpu(), pages).flip(0).float(), inside, inside)
        for _ in range(_SETTLING):
            source = self.whole(source, inside)
        return self.shown(source, inside)

    def shown(self, source: Tensor, inside: Tensor) -> Frame:
        """What copies at source coordinates (2, H, W) show inside (H, W), as frame 0."""
        torn = None if self.mortar is None else self.mortar.torn(source, inside)
        seen = self.seen(source, inside, torn)
        return self._frame(State(0, source, inside, self.showing.first(seen, inside), torn=torn), seen, {})

    def whole(self, source: Tensor, inside: Tensor) -> Tensor:
        """Source coordinates (2, H, W) inside (H, W), elements drawn anew, each whole, where the exemplar has such."""
        return source if self.cells is None else redrawn(source.flip(0), inside, self.cells).flip(0)

    def seen(self, source: Tensor, inside: Tensor, torn: Tensor | None) -> Tensor:
        """Where (2, H, W) to read what source coordinates show inside (H, W): with joints where walls are torn.

        torn (H, W): as in `State`.
        """
        return source if self.mortar is None or torn is None else self.mortar.shown(source, inside, torn)

    def resumed(self, state: State) -> Frame:
        """The frame that a state shows."""
        return self._frame(state, self.seen(state.source, state.inside, state.torn), {})

    def step(self, state: State) -> Frame:
        """The frame that follows a state."""
        number = state.number + 1
        flow = self._flow(state.number)
        inside = self.allowed(number)
        if self.enter is None:
            look = self._lookup(flow, state.inside)
        else:
            allowed = self.allowed(state.number)
            look = self._lookup(flow, allowed)
            inside = inside & entered(flow, look, state.inside, allowed, self.enter, state.number)
            look = known_of(look, state.inside)
        generator = generator_of(self.seed, number)
        source = carried(state.source, look, state.inside)
        moved = inside & (source != state.source).any(0)
        older = tidied(source, moved, inside)
        if self.upright is not None:
            older = self.upright(older, moved)
        source = self.film.onward(older)
        if self.film.hidden is not None and self.cells is None:
            depth = torch.from_numpy(self.film.hidden.depth)
            source = overlapped(source, moved, inside, depth, self.film.read.usable)
        lives = inside & (source != older).any(0)
        left = None if state.left is None else warp(state.left[None], look.coordinates, "nearest")[0] * look.known
        place = places_onward(self.film, state.place, state.source, look, state.inside)
        new, image, left, report = self.renewal(source, inside, generator, moved | lives, left, place)
        if place is not None:
            place = torch.where(self.film.read.usable(source), place, places(self.film, new))
        drawn = self.whole(new, inside) if bool(moved.any()) else new
        torn = None if self.mortar is None else self.mortar.torn(drawn, inside, look, state.torn)
        seen = self.seen(drawn, inside, torn)
        shown, fading = self.showing.next(state, look, source, seen, inside, image if seen is new else None)
        return self._frame(State(number, drawn, inside, shown, fading, left, place, torn), seen, report)

    def _flow(self, number: int) -> Tensor:
        """The flow (2, H, W) from a frame to the next; that of a steady field is asked for once."""
        if self._flowing is None or not self.field.steady:
            self._flowing = self.field(number, self.shape).cpu()
        return self._flowing

    def _lookup(self, flow: Tensor, inside: Tensor) -> Lookup:
        if self.field.steady and self._steady is not None and torch.equal(self._steady[0], inside):
            return self._steady[1]
        look = lookup(flow, None if bool(inside.all()) else inside)
        self._steady = inside, look
        return look

    def _frame(self, state: State, seen: Tensor, report: dict[str, float]) -> Frame:
        """A state as a frame that is read at `seen` (2, H, W)."""
        pixels = self.film.read.pixels(seen)
        where, origin = self.film.where(pixels), look_up(self.film.strip.origin, pixels)
        origin[:1] = torch.where(state.inside, origin[:1], -1)
        rows: list[Row] = [{"frame": state.number, **report}]
        shown = torch.where(state.inside, state.image, 0.0)
        colors, maps = shown.tensor_split([self.showing.channels])
        return Frame(colors, origin, where, rows, [], "", state, maps if len(maps) else None)
