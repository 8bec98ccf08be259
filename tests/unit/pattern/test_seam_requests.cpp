// What a case asks of seams: many at once, how far along them pairs are, places of points.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "test_pattern_kit.hpp"

namespace test_seam_requests {

using namespace voile;
using namespace voile::testing;
using pattern::Panel;
using pattern::SeamRequest;

TEST_CASE("a star in names of pieces makes a seam for each text that it stands for on both sides") {
  const std::vector<Panel> panels{
      rectangle("sleeve_l", 0.3, 0.4, 0.1), moved(rectangle("body_l", 0.3, 0.4, 0.1), {0.4, 0, 0}),
      moved(rectangle("sleeve_r", 0.3, 0.4, 0.1), {0, 1, 0}), moved(rectangle("body_r", 0.3, 0.4, 0.1), {0.4, 1, 0})};
  SeamRequest r = seam({"sleeve_*/1"}, {"body_*/3"}, {"sleeve_*@1", "body_*@0"});
  r.name = "armhole *";
  const std::vector<SeamRequest> both = pattern::with_stars_replaced(panels, r);
  REQUIRE(both.size() == 2);
  CHECK(both[1].name == "armhole r");
  CHECK(both[1].edges == std::vector<std::string>{"sleeve_r/1"});
  CHECK(both[1].meet == std::vector<std::string>{"sleeve_r@1", "body_r@0"});
  CHECK(pattern::make_garment(panels, both).seams.lines[0].name == "armhole l");
  CHECK(pattern::with_stars_replaced(panels, seam({"sleeve_l/1"}, {"body_l/3"})).size() == 1);
  const auto refused = [&](const std::vector<Panel>& some, const SeamRequest& request) -> std::string {
    try {
      (void)pattern::with_stars_replaced(some, request);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  CHECK(
      has(refused(panels, seam({"cuff_*/1"}, {"body_*/3"})), "test: 'cuff_*/1': no piece matches; there are sleeve_l"));
  CHECK(has(refused({panels[0], panels[1], panels[2]}, seam({"sleeve_*/1"}, {"body_*/3"})),
            "the * of 'sleeve_*/1' stands for l, r, that of 'body_*/3' for l"));
  CHECK(has(refused(panels, seam({"sleeve_*/1"}, {"body_l/3"})), "to: there is no * in it"));
  CHECK(has(refused(panels, seam({"sleeve_l/*"}, {"body_*/3"})), "a text in the name of a piece"));
  r.name = "armhole";
  CHECK(has(refused(panels, r), "name: 2 seams would have it"));
}

TEST_CASE("pairs of a seam know how far along it they are, from the points of meet on") {
  const std::vector<Panel> panels{rectangle("A", 0.3, 0.4, 0.1), moved(rectangle("B", 0.3, 0.4, 0.1), {0.4, 0, 0})};
  for (const bool from_above : {false, true}) {
    const auto meet = from_above ? std::vector<std::string>{"A@2", "B@3"} : std::vector<std::string>{"A@1", "B@0"};
    const pattern::Garment g = pattern::make_garment(panels, {seam({"A/1"}, {"B/3"}, meet)});
    const mesh::Seam& s = g.mesh.seams.front();
    REQUIRE(s.stations.size() == s.pairs.size());
    for (std::size_t k = 0; k < s.pairs.size(); ++k) {
      const double y = g.mesh.positions[s.pairs[k][0]][1];
      CHECK(s.stations[k] == doctest::Approx(from_above ? 0.4 - y : y).epsilon(1e-12));
    }
  }
}

TEST_CASE("the place of a point of a piece, before it is bent") {
  Panel p = moved(rectangle("A", 0.3, 0.4, 0.1), {1, 2, 3});
  p.turn = Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3::UnitZ()).toRotationMatrix();
  CHECK((pattern::flat_place({p}, "test", "A@2") - Vec3(0.6, 2.3, 3.0)).norm() < 1e-14);
}

}  // namespace test_seam_requests
