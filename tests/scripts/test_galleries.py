import gallery_controls
import gallery_projection
import torch


def test_the_ablation_runs_its_variants_and_draws_them(tmp_path, capsys):
    import ablation

    from synth import Kind, write_image

    image = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    write_image(tmp_path / "noise.png", image, Kind("uint8", ("Y",)))
    words = [str(tmp_path / "noise.png"), "--size", "40x40", "--out", str(tmp_path / "out")]
    assert ablation.main([*words, "--only", "default", "colors carried", "histogram"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("default", "colors carried", "histogram", "overall"))
    assert (tmp_path / "out" / "contact_sheet.png").stat().st_size > 1000
    assert ablation.main(["missing", "--images", str(tmp_path)]) == 2


def test_the_projection_figure_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(gallery_projection, "TWIRLS", (0.7,))
    rows = gallery_projection.main(["--out", str(tmp_path / "figure.png"), "--size", "64"])
    assert rows[0]["three"] < rows[0]["start"]
    assert (tmp_path / "figure.png").is_file()


def test_the_figure_of_controls_is_drawn_with_its_holes_filled(tmp_path, capsys):
    from synth import read_image

    gallery_controls.main(["--out", str(tmp_path / "new" / "controls.png"), "--side", "60"])
    sheet = read_image(tmp_path / "new" / "controls.png").pixels
    assert sheet.shape == (3, 252, 252)
    hole, filled = sheet[:, :60, :60], sheet[:, :60, 64:124]
    white = (hole == 1).all(0)
    assert 0.08 < float(white.float().mean()) < 0.2
    assert torch.equal(hole[:, ~white], filled[:, ~white])
    assert float((filled == 1).all(0)[white].float().mean()) < 0.1
    part, continued, sign, behind = (sheet[:, 192:, 64 * column :][..., :60] for column in range(4))
    assert torch.equal(part[:, 12:48, 12:48], continued[:, 12:48, 12:48])
    assert float((continued == 1).all(0).float().mean()) < 0.1
    assert torch.equal(sign[:, 22:38, 22:38], behind[:, 22:38, 22:38])
    assert float((behind[:, :10] == 1).all(0).float().mean()) < 0.1
    assert "controls.png" in capsys.readouterr().out
