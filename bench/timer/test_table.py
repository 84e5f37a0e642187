"""Checks the table of hand-made results: python -m unittest bench.timer.test_table."""

import unittest

from bench.timer import jobs, table


def runs(ms: float, **facts: object) -> list[list[dict]]:
    return [[{"cpu_ms": [ms], "own_ms": [ms], "wall_ms": [ms], "fingerprint": "1", **facts}]]


def result(faces: int, reference: float, default: float, error: float) -> dict:
    """The plain reference has D .1 and borders of length 10."""
    plain = {"error": 0.1, "border_length": 10.0}
    return {
        "mesh": {"faces": faces},
        "cases": {
            "reference": runs(reference, round_ms=[reference / 20] * 20, **plain),
            "lloyd": runs(reference / 7, **plain),
            "default": runs(default, error=error, border_length=10.5),
            "default_two_threads": runs(default / 1.6, error=error, border_length=10.5),
            "mesh": runs(20.0),
        },
    }


class Table(unittest.TestCase):
    def rows(self, name: str, given: dict) -> dict[str, table.Row]:
        return {row.what.split(",")[0]: row for row in table.rows({name: given}, {})}

    def test_a_fast_good_run_meets_all_bars(self) -> None:
        rows = self.rows("dragon/500", result(871_414, 7000, 70, 0.079))
        assert all(row.met for row in rows.values()), rows
        assert "7.0 x, D +0.0 %" in rows["lloyd"].measured

    def test_a_slow_run_or_a_bad_one_does_not(self) -> None:
        slow = table.rows({"dragon/500": result(871_414, 7000, 90, 0.079)}, {})
        bad = table.rows({"dragon/500": result(871_414, 7000, 70, 0.081)}, {})
        for rows in (slow, bad):
            assert [row.met for row in rows if row.what.startswith("default, one")] == [False]

    def test_a_small_mesh_has_its_own_bars_and_a_stress_mesh_none(self) -> None:
        assert self.rows("bunny/500", result(69_451, 340, 8, 0.089))["default"].met
        stress = table.rows({"slivers/500": result(200_000, 340, 80, 0.2)}, {})
        assert [row.met for row in stress if row.what.startswith("default, one")] == [None]

    def test_other_labels_on_two_threads_are_an_error(self) -> None:
        given = result(871_414, 7000, 70, 0.079)
        assert table.sound(table.rows({"dragon/500": given}, {}), {"dragon/500": given})
        given["cases"]["default_two_threads"][0][0]["fingerprint"] = "2"
        rows = table.rows({"dragon/500": given}, {})
        assert not table.sound(rows, {"dragon/500": given})
        assert "OTHER" in table.text(rows, judge=True)

    def test_other_polygons_on_two_threads_are_an_error(self) -> None:
        given = result(871_414, 7000, 70, 0.079)
        for case, ms in (("polygonize", 400.0), ("polygonize_two_threads", 250.0), ("polygonize_planar", 700.0)):
            given["cases"][case] = runs(ms, polygons=600, manifold=True)
        rows = table.rows({"dragon/500": given}, {})
        assert table.sound(rows, {"dragon/500": given})
        assert any(row.measured == "1.60 x (wall: 1.60 x), same polygons" for row in rows)
        assert any(row.measured == "2.00 REF rounds" and "planar" in row.what for row in rows)
        given["cases"]["polygonize_two_threads"][0][0]["fingerprint"] = "2"
        rows = table.rows({"dragon/500": given}, {})
        assert not table.sound(rows, {"dragon/500": given})
        assert "OTHER polygons" in table.text(rows, judge=True)

    def test_growth_is_the_spread_of_the_time_a_face(self) -> None:
        growth = {f"faces/{n}": result(n, 100, ms, 0.1) for n, ms in ((1000, 10), (10_000, 120))}
        (row,) = table.growth_rows(growth)
        assert (row.measured, row.met) == ("1.20", True)

    def test_nothing_against_nothing_is_equal(self) -> None:
        assert table.relative(0.0, 0.0) == 1.0

    def test_every_job_of_the_table_has_a_name_of_its_own(self) -> None:
        for plan in (jobs.full(3), jobs.quick(), jobs.growth(quick=False)):
            names = [job.name for job in plan]
            assert len(names) == len(set(names))


if __name__ == "__main__":
    unittest.main()
