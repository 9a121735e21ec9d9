#include "paper/model/setup_json.hpp"

#include <limits>
#include <nlohmann/json.hpp>

namespace slipd {
namespace {

using nlohmann::json;

// JSON has no infinity; CBOR has, but nlohmann's reader of it gives null back for nothing else than null.
json number(double value) {
  return value == std::numeric_limits<double>::infinity() ? json("flat") : json(value);
}

double number_of(const json& from) {
  return from == "flat" ? std::numeric_limits<double>::infinity() : from.get<double>();
}

json to_json(const Range& range) {
  return {range.low, range.high};
}

Range range_of(const json& from) {
  return {from.at(0), from.at(1)};
}

json to_json(const TaxelLayout& layout) {
  if (const auto& grid = layout.regular()) {
    return {{"columns", grid->columns}, {"rows", grid->rows}, {"pitch_m", grid->pitch_m}};
  }
  return {{"x_m", std::vector<double>(layout.x_m().begin(), layout.x_m().end())},
          {"y_m", std::vector<double>(layout.y_m().begin(), layout.y_m().end())}};
}

TaxelLayout layout_of(const json& from) {
  if (from.contains("columns"))
    return TaxelLayout::grid(from.at("columns"), from.at("rows"), from.at("pitch_m"));
  return TaxelLayout::scattered(from.at("x_m"), from.at("y_m"));
}

json to_json(const ObjectFamily& family) {
  return {{"weight", family.weight},
          {"normal_n", to_json(family.normal_n)},
          {"friction", to_json(family.friction)},
          {"radius_m", to_json(family.radius_m)},
          {"flat_share", family.flat_share},
          {"modulus_pa", to_json(family.modulus_pa)},
          {"poisson", to_json(family.poisson)}};
}

ObjectFamily family_of(const json& from) {
  return {.weight = from.at("weight"),
          .normal_n = range_of(from.at("normal_n")),
          .friction = range_of(from.at("friction")),
          .radius_m = range_of(from.at("radius_m")),
          .flat_share = from.at("flat_share"),
          .modulus_pa = range_of(from.at("modulus_pa")),
          .poisson = range_of(from.at("poisson"))};
}

json to_json(const Scene& scene) {
  json objects = json::array();
  for (const auto& family : scene.objects) objects.push_back(to_json(family));
  return {{"skin", {number(scene.skin.radius_m), scene.skin.modulus_pa, scene.skin.poisson}},
          {"objects", std::move(objects)},
          {"offset_m", scene.offset_m},
          {"noise", scene.noise}};
}

Scene scene_of(const json& from) {
  Scene scene;
  const json& skin = from.at("skin");
  scene.skin = {.radius_m = number_of(skin.at(0)), .modulus_pa = skin.at(1), .poisson = skin.at(2)};
  for (const auto& family : from.at("objects")) scene.objects.push_back(family_of(family));
  scene.offset_m = from.at("offset_m");
  scene.noise = from.at("noise");
  return scene;
}

}  // namespace

nlohmann::json to_json(const ModelSetup& setup) {
  return {{"layout", to_json(setup.layout)},
          {"scene", to_json(setup.scene)},
          {"contacts", setup.size.contacts},
          {"loads", setup.size.loads},
          {"seed", setup.seed},
          {"rank", setup.rank},
          {"neighbours", setup.neighbours},
          {"view", setup.view == View::rings ? "rings" : "grid"},
          {"rings", setup.rings}};
}

ModelSetup setup_of(const nlohmann::json& from) {
  return {.layout = layout_of(from.at("layout")),
          .scene = scene_of(from.at("scene")),
          .size = {from.at("contacts"), from.at("loads")},
          .seed = from.at("seed"),
          .rank = from.at("rank"),
          .neighbours = from.at("neighbours"),
          .view = from.at("view") == "rings" ? View::rings : View::grid,
          .rings = from.at("rings")};
}

}  // namespace slipd
