"""What others may rely on: the public lists, pinned. A name added or taken away is a decision, made here."""

import importlib

import pytest

import flow
import kwatra
import synth

PUBLIC = {
    kwatra: """THESIS Bags Ballot Beginning Charge CheapestSeams Decisive Exemplar Feature FreeWindows Grid HardPixels
        InputError Lattice Level Mode PlaceCharge Prepared Progress Pull Quadratic Result Rows Scaled Settings
        SoftPixels Solver Stage Stay Step Sum Term TermLike begin direction_dependence element_size find_lattice
        find_rows gradient improve match_histogram mean measure optimize place_dependence planned_levels
        regular winner""",
    flow: """NAMES PRESETS Field Frame Lookup Renewing State VolumeFlow Warp animate around at_speed disc disc_mask
        VIDEO_PRESETS end_point_error filled flow_term lookup loop named noise picture published resampled rotation
        saddle sampled seen shear sink source stream uniform vortices warp waves wheel""",
    synth: """InputError Interpolated Kind Metamorphosis Picture Recording Synthesis field_of fill interpolate morph
        read_flow read_image synthesize tile write_flow write_image""",
}


@pytest.mark.parametrize("package", PUBLIC, ids=lambda package: package.__name__)
def test_the_public_list_is_as_pinned(package):
    assert sorted(package.__all__) == sorted(PUBLIC[package].split())


@pytest.mark.parametrize("package", PUBLIC, ids=lambda package: package.__name__)
def test_every_public_name_is_there_and_says_what_it_is(package):
    for name in package.__all__:
        thing = getattr(package, name)
        if callable(thing) and getattr(thing, "__module__", "").split(".")[0] in ("kwatra", "flow", "synth"):
            assert thing.__doc__, f"{package.__name__}.{name} says nothing"


@pytest.mark.parametrize(
    "folder", ["base", "elements", "windows", "source", "terms", "cut", "pieces", "steps", "loop", "scoring"]
)
def test_every_folder_of_the_engine_lists_what_its_neighbors_may_use(folder):
    package = importlib.import_module(f"kwatra.{folder}")
    assert package.__all__
    assert all(hasattr(package, name) for name in package.__all__)
