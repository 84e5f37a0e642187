#include <bit>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "mesh_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::kHouse;
using checks::raw;

namespace fs = std::filesystem;

class Io : public checks::InFolder {
 protected:
  fs::path file(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  PolygonSoup parse(const std::string& name, const std::string& bytes, Columns* columns = nullptr) const {
    return read_polygons(file(name, bytes), job(), 0, columns);
  }
  /// The error's text after the file's name.
  std::string error(const std::string& name, const std::string& bytes) const {
    const std::string what = message_of<FileError>([&] { parse(name, bytes); }),
                      path = (folder_ / name).string() + ": ";
    EXPECT_TRUE(what.starts_with(path)) << what;
    return what.substr(std::min(what.size(), path.size()));
  }
  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
};

void expect_same(const PolygonSoup& a, const PolygonSoup& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.loops, b.loops);
  EXPECT_EQ(a.loop_start, b.loop_start);
}

void save(const fs::path& path, const PolygonSoup& soup) {
  write_polygons(path, soup.vertices, soup.loops, soup.loop_start, job());
}

PolygonSoup load(const fs::path& path) { return read_polygons(path, job()); }

TEST_F(Io, PlyAndObjAreReadBackBitForBit) {
  PolygonSoup soup = kHouse;
  soup.vertices[6] = {1.0 / 3, -5e6 - 0.123456789, 1e-300};
  for (const char* name : {"a.ply", "a.obj", "b.PLY", "b.Obj"}) {
    save(folder_ / name, soup);
    expect_same(load(folder_ / name), soup);
  }
  EXPECT_EQ(files_in_folder(), 4);
}

TEST_F(Io, APolygonOfManyCornersAndNoneAreReadBack) {
  PolygonSoup soup;
  soup.vertices = {{1, 2, 3}};
  save(folder_ / "none.ply", soup);
  expect_same(load(folder_ / "none.ply"), soup);
  soup.vertices.clear();
  for (std::int32_t i = 0; i < 1000; ++i) {
    soup.vertices.emplace_back(std::cos(i * 0.00628), std::sin(i * 0.00628), 0);
    soup.loops.push_back(i);
  }
  soup.loop_start = {0};
  for (const char* name : {"a.ply", "a.obj"}) {
    save(folder_ / name, soup);
    expect_same(load(folder_ / name), soup);
  }
}

TEST_F(Io, WritingReplacesWholeFilesOnly) {
  save(folder_ / "a.ply", kHouse);
  PolygonSoup bad = kHouse;
  bad.loops[2] = 7;
  EXPECT_THROW(save(folder_ / "a.ply", bad), InvalidInput);
  Job job;
  job.cancel();
  EXPECT_THROW(write_polygons(folder_ / "a.ply", kHouse.vertices, kHouse.loops, kHouse.loop_start, job), Cancelled);
  EXPECT_EQ(files_in_folder(), 1);
  expect_same(load(folder_ / "a.ply"), kHouse);
  fs::create_directory(folder_ / "b.ply");
  EXPECT_THROW(save(folder_ / "b.ply", kHouse), FileError);
  EXPECT_THROW(save(folder_ / "nowhere" / "c.ply", kHouse), FileError);
  EXPECT_THROW(save(folder_ / "c.stl", kHouse), FileError);
  EXPECT_EQ(files_in_folder(), 2);
  PolygonSoup short_polygon = kHouse;
  short_polygon.loop_start = {0, 2, 7};
  EXPECT_THROW(save(folder_ / "d.obj", short_polygon), InvalidInput);
  EXPECT_EQ(files_in_folder(), 2);
}

const std::string kPlyHead =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n";

TEST_F(Io, PlyInAllThreeEncodings) {
  const PolygonSoup text = parse("a.ply", "ply\nformat ascii 1.0\n" + kPlyHead + "0 0 0\n1 0 0\n0 1e0 -0.5\n3 0 1 2\n");
  EXPECT_EQ(text.vertices[2], Vec3(0, 1, -0.5));
  EXPECT_EQ(text.loops, (Array<std::int32_t>{0, 1, 2}));
  for (const bool big : {false, true}) {
    std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + kPlyHead;
    for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, -0.5F}) bytes += raw(x, big);
    bytes += '\3';
    for (const std::int32_t v : {0, 1, 2}) bytes += raw(v, big);
    expect_same(parse("b.ply", bytes), text);
  }
}

TEST_F(Io, PlySkipsUnusedProperties) {
  const std::string head =
      "ply\r\nformat ascii 1.0\r\ncomment end_header is not here\r\nobj_info x\r\nelement camera 2\r\n"
      "property list uint8 float32 view\r\nproperty int32 id\r\nelement vertex 3\r\nproperty uchar red\r\n"
      "property float64 z\r\nproperty double x\r\nproperty list int uchar notes\r\nproperty double y\r\n"
      "element face 2\r\nproperty float quality\r\nproperty list uint uint vertex_index\r\n"
      "property list uchar float texcoord\r\nelement edge 1\r\nproperty int a\r\nend_header\r\n";
  const PolygonSoup soup = parse("a.ply", head +
                                              "2 0.5 0.25 7\r\n0 8\r\n255 3 1 2 9 9 2\r\n0 6 4 0 5\r\n0 9 7 0 8\r\n"
                                              "0.5 3 0 1 2 2 0.1 0.2\r\n0.5 3 2 1 0 0\r\n1\r\n");
  EXPECT_EQ(soup.vertices, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  EXPECT_EQ(soup.loops, (Array<std::int32_t>{0, 1, 2, 2, 1, 0}));
}

const std::string kPlyOfColumns =
    "ply\nformat ascii 1.0\ncomment TextureFile a b.png \nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar notes\nelement face 2\n"
    "property list uchar float texcoord\nproperty list uchar int vertex_indices\nproperty short red\nend_header\n"
    "0 0 0 7 x\n1 0 0 8 x\n0 1 0 9 x\n6 .1 .2 .3 .4 .5 .6 3 0 1 2 -5\n0 2 2 1 6\n";

TEST_F(Io, PlyColumnsThatAreWantedAreRead) {
  Columns columns;
  columns.names = {"red", "green"};
  const PolygonSoup soup = parse("a.ply", kPlyOfColumns, &columns);
  EXPECT_EQ(soup.loops, (Array<std::int32_t>{0, 1, 2, 2, 1}));
  ASSERT_EQ(columns.vertices.size(), 1);
  EXPECT_EQ(columns.vertices[0].name + columns.vertices[0].kind, "redu1");
  EXPECT_EQ(columns.vertices[0].values, (std::vector<double>{7, 8, 9}));
  ASSERT_EQ(columns.faces.size(), 1);
  EXPECT_EQ(columns.faces[0].kind, "i2");
  EXPECT_EQ(columns.faces[0].values, (std::vector<double>{-5, 6}));
  EXPECT_EQ(columns.uv.value(), (std::vector<double>{.1, .2, .3, .4, .5, .6, 0, 0, 0, 0}));
  EXPECT_EQ(columns.files, std::vector<std::string>{"a b.png"});
  EXPECT_EQ(columns.skipped, std::vector<std::string>{"notes"});
}

TEST_F(Io, WhatIsSkippedIsNamed) {
  const auto skipped = [&](const std::string& name, const std::string& bytes) {
    Columns columns;
    parse(name, bytes, &columns);
    return columns.skipped;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(skipped("a.obj", "# c\no a\ng b\ns 1\nv 0 0 0\nvn 0 0 1\nvn 0 0 1\nf 1//1 1//1 1//1\nl 1 1\n"),
            (Names{"vn", "l"}));
  EXPECT_EQ(skipped("a.ply",
                    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                    "property float nx\nelement face 1\nproperty list uchar int vertex_indices\nproperty int flags\n"
                    "element edge 1\nproperty int a\nelement none 0\nend_header\n0 0 0 1\n3 0 0 0 1\n1\n"),
            (Names{"nx", "flags", "edge"}));
  EXPECT_EQ(skipped("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 0\n"), Names{});
  EXPECT_EQ(skipped("a.off", "OFF\n1 2 0\n0 0 0\n3 0 0 0\n3 0 0 0 255 0 0\n"), Names{"C"});
  EXPECT_EQ(skipped("a.off", "STCNOFF\n1 1 0\n0 0 0\n3 0 0 0\n"), (Names{"ST", "C", "N"}));
  std::string stl(84 + 50, '\0');
  stl[80] = 1;
  EXPECT_EQ(skipped("a.stl", stl), Names{});
  stl.back() = 1;
  EXPECT_EQ(skipped("a.stl", stl), Names{"C"});
}

TEST_F(Io, PlyTextKeepsNaNAndReadsOn) {
  const PolygonSoup soup =
      parse("a.ply", "ply\nformat ascii 1.0\n" + kPlyHead + "nan 0 -1.#IND\ninf 0 1e999\n0 1 5\n3 0 1 2");
  EXPECT_TRUE(std::isnan(soup.vertices[0].x()));
  EXPECT_TRUE(std::isnan(soup.vertices[0].z()));
  EXPECT_EQ(soup.vertices[1].z(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(soup.vertices[2], Vec3(0, 1, 5));
}

TEST_F(Io, DamagedPlyIsNamed) {
  const std::string text = "ply\nformat ascii 1.0\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n";
  EXPECT_NE(error("a.ply", "solid x").find("does not begin with \"ply\""), std::string::npos);
  EXPECT_NE(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n").find("no end_header"), std::string::npos);
  EXPECT_NE(error("a.ply", "ply\nelement vertex 3\nend_header\n").find("no format line"), std::string::npos);
  EXPECT_EQ(error("a.ply", text + "property float x\nend_header\n"), "line 3: a PLY property comes before any element");
  EXPECT_EQ(error("a.ply", "ply\nformat binary_middle 1.0\n"), "line 2: unknown PLY format \"binary_middle\"");
  EXPECT_EQ(error("a.ply", text + "element vertex -3\n"),
            "line 3: element \"vertex\" needs its number of rows, got \"-3\"");
  EXPECT_EQ(error("a.ply", text + "element vertex 3\nproperty float16 x\n"),
            "line 4: a PLY header names the unknown type \"float16\"");
  EXPECT_EQ(error("a.ply", text + "element vertex 0\nend_header\n"), "the PLY vertices have no x, y and z");
  EXPECT_EQ(error("a.ply", text + "element face 0\nend_header\n"), "the PLY header has no vertex element");
  EXPECT_EQ(error("a.ply", text + kPlyHead + "0 0 0\n1 0 oops\n0 1 0\n3 0 1 2\n"),
            "line 11: expected a number for vertex 1 (the first is 0), got \"oops\"");
  EXPECT_EQ(error("a.ply", text + kPlyHead + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "face 0 (the first is 0) uses vertex 3, but there are 3 vertices, the first of them 0");
  EXPECT_EQ(error("a.ply", text + kPlyHead + "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"),
            "face 0 (the first is 0) uses an impossible vertex, but there are 3 vertices, the first of them 0");
  EXPECT_EQ(error("a.ply", text + kPlyHead + "0 0 0\n1 0 0\n0 1 0\n3 0 1"),
            "it ends within face 0 (the first is 0) of 1; it is cut short or damaged");
  EXPECT_NE(
      error("a.ply", text + kPlyHead + "0 0 0\n1 0 0\n0 1 0\n4000000000 0 1").find("promises a list of 4000000000"),
      std::string::npos);
  const std::string billion =
      "element vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const std::string& kind : {text, binary})
    EXPECT_NE(error("a.ply", kind + billion + "abc").find("promises 1000000000 of element \"vertex\""),
              std::string::npos);
  EXPECT_NE(
      error("a.ply", binary + kPlyHead + std::string(36, '\0') + "\3" + raw(0) + raw(1)).find("ends within face 0"),
      std::string::npos);
  const std::string strips =
      "element vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n";
  EXPECT_EQ(error("a.ply", text + strips + "property list int int vertex_indices\nend_header\n3 0 1 2\n"),
            "face 0 (the first is 0) uses vertex 0, but there are 0 vertices, the first of them 0");
  EXPECT_NE(error("a.ply", text + strips + "property int vertex_indices\nend_header\n3\n")
                .find("triangle strips have no list"),
            std::string::npos);
}

TEST_F(Io, PlyTriangleStripsBecomeTriangles) {
  // Two strips: of five vertices, the second and fourth triangle turned over; and of three. 5 5 turns the second one.
  const std::vector<std::int32_t> strip{0, 1, 2, 3, 4, -1, 4, 5, 5, 3, -1};
  const std::string head =
      "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  std::string words = "11", bytes = raw(11), text, floats;
  for (const std::int32_t v : strip) {
    words += ' ';
    words += std::to_string(v);
    bytes += raw(v);
  }
  for (int v = 0; v < 6; ++v) {
    text += std::to_string(v);
    text += " 0 0\n";
    floats += raw(static_cast<float>(v)) + raw(0.0F) + raw(0.0F);
  }
  for (const PolygonSoup& soup : {parse("t.ply", "ply\nformat ascii 1.0\n" + head + text + words + "\n"),
                                  parse("b.ply", "ply\nformat binary_little_endian 1.0\n" + head + floats + bytes)}) {
    EXPECT_EQ(soup.loops, (Array<std::int32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4}));
    EXPECT_EQ(soup.loop_start, (Array<std::int32_t>{0, 3, 6}));
  }
}

TEST_F(Io, ObjTakesItsManySpellings) {
  const PolygonSoup soup =
      parse("a.obj",
            "# comment\nmtllib none.mtl\no thing\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\r\nvt 0 0\nvn 0 0 1\n"
            "v 1 1 0\n\tv  +0 1e0 0 1\ng a\nusemtl b\ns off\nf 1/1/1 2//1 3/1\nf -4 \\\n -2 -1\n"
            "f 1 2 3 4 # quad\nf 1 1 2\nl 1 2\np 1\nf 5 2 1\nv 9 9 9");
  EXPECT_EQ(soup.vertices.size(), 5);
  EXPECT_EQ(soup.vertices[3], Vec3(0, 1, 0));
  EXPECT_EQ(soup.loops, (Array<std::int32_t>{0, 1, 2, 0, 2, 3, 0, 1, 2, 3, 0, 0, 1, 4, 1, 0}));
  EXPECT_EQ(soup.loop_start, (Array<std::int32_t>{0, 3, 6, 10, 13}));
}

const std::string kObjOfColumns =
    "mtllib a b.mtl \nv 0 0 0 .5 0 1\nv 1 0 0 1 .5 0 1\nvt .1 .2\nvt .3\nusemtl a\nusemtl b\nf 1/-1 2/3 1// \\\n"
    "2/1\nvt .5 .6\nusemtl a\nf 1 2/1#\n";

TEST_F(Io, ObjColumnsAreRead) {
  Columns columns;
  EXPECT_EQ(parse("a.obj", kObjOfColumns, &columns).loops, (Array<std::int32_t>{0, 1, 0, 1, 0, 1}));
  EXPECT_EQ(columns.uv.value(), (std::vector<double>{.3, 0, .5, .6, 0, 0, .1, .2, 0, 0, .1, .2}));
  EXPECT_EQ(columns.files, std::vector<std::string>{"a b.mtl"});
  using Uses = std::vector<std::pair<std::int32_t, std::string>>;
  EXPECT_EQ(columns.materials, (Uses{{0, "a"}, {0, "b"}, {1, "a"}}));
  ASSERT_EQ(columns.vertices.size(), 3);
  EXPECT_EQ(columns.vertices[0].values, (std::vector<double>{.5, .5}));
  EXPECT_EQ(columns.vertices[2].values, (std::vector<double>{1, 1}));
}

TEST_F(Io, DamagedObjIsNamed) {
  EXPECT_EQ(error("a.obj", "hello\n"), "it has no line that begins with \"v \", as an OBJ file does");
  EXPECT_EQ(error("a.obj", "v 0 0\n"), "line 1: expected three coordinates after \"v\", got \"\"");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf /1 /2 /3\n"),
            "line 2: expected the number of a vertex (1 is the first), got \"/1\"");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf 0 1 1\n"),
            "line 2: expected the number of a vertex (1 is the first), got \"0\"");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf -2 1 1\n"), "line 2: vertex \"-2\" lies before the first, there are 1 so far");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf 1 1 99\n"),
            "face 0 (the first is 0) uses vertex 99, but there are 1 vertices, the first of them 1");
}

std::string binary_stl(const shapes::Arrays& a) {
  std::string bytes = std::string("solid that is not text") + std::string(58, ' ');
  bytes += raw(static_cast<std::uint32_t>(a.triangles.size()));
  for (const Triangle& t : a.triangles) {
    bytes += std::string(12, '\0');
    for (const std::int32_t v : t)
      for (const double x : a.vertices[v]) bytes += raw(static_cast<float>(x));
    bytes += std::string(2, '\0');
  }
  return bytes;
}

std::string text_stl(const shapes::Arrays& a) {
  std::ostringstream out;
  out << "solid outer vertex\n";
  for (const Triangle& t : a.triangles) {
    out << " facet normal 0 0 0\n  OUTER LOOP\n";
    for (const std::int32_t v : t) out << "   vertex " << a.vertices[v].transpose() << "\n";
    out << "  endloop\n endfacet\n";
  }
  out << "endsolid\n";
  return out.str();
}

TEST_F(Io, StlSharesCornersAndKeepsEveryFacet) {
  const shapes::Arrays cube = shapes::cube(2);
  for (const std::string& bytes : {binary_stl(cube), binary_stl(cube) + "more", text_stl(cube)}) {
    const PolygonSoup soup = parse("a.stl", bytes);
    EXPECT_EQ(soup.vertices.size(), 26);
    ASSERT_EQ(soup.polygon_count(), 48);
    for (std::int32_t q = 0; q < 48; ++q)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(soup.vertices[soup.polygon(q)[k]], cube.vertices[cube.triangles[q][k]]);
  }
  shapes::Arrays bad = shapes::cube();
  bad.vertices[0].x() = std::nan("");
  bad.triangles.push_back({1, 1, 2});
  const PolygonSoup soup = parse("b.stl", binary_stl(bad));
  EXPECT_EQ(soup.polygon_count(), 13);
  EXPECT_GT(soup.vertices.size(), 8);  // a corner that is not a number is like no other
}

TEST_F(Io, TextStlWithoutItsEndIsCutShort) {
  const std::string whole = text_stl(shapes::cube()),
                    missing = "it has no \"endsolid\" after its last facet; it is cut short";
  EXPECT_EQ(parse("a.stl", whole).polygon_count(), 12);
  for (const char* end : {"endsolid", "endfacet", "endloop", " facet"})
    EXPECT_EQ(error("a.stl", whole.substr(0, whole.rfind(end))), missing) << end;
  EXPECT_EQ(error("a.stl", "solid a\n"), missing);
  EXPECT_EQ(parse("a.stl", "solid a\nendsolid a\n").polygon_count(), 0);
  EXPECT_EQ(parse("two.stl", whole + whole).polygon_count(), 24);
  EXPECT_EQ(error("two.stl", whole + whole.substr(0, whole.rfind("endsolid"))), missing);
}

TEST_F(Io, TextStlMayBeOneLine) {
  std::string text = text_stl(shapes::cube());
  std::replace(text.begin(), text.end(), '\n', ' ');
  EXPECT_EQ(parse("a.stl", text).loops, parse("b.stl", text_stl(shapes::cube())).loops);
  const std::string solid =
      "solid the facet one facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 "
      "endloop endfacet endsolid the facet one ";
  EXPECT_EQ(parse("a.stl", solid + solid).polygon_count(), 2);
  EXPECT_EQ(parse("b.stl", "solid vertex endsolid\n" + solid).polygon_count(), 1);
}

TEST_F(Io, DamagedStlIsNamed) {
  EXPECT_NE(error("a.stl", "hello").find("neither a text STL file"), std::string::npos);
  EXPECT_NE(error("a.stl", binary_stl(shapes::cube()).substr(0, 300)).find("promises 12 facets"), std::string::npos);
  EXPECT_EQ(error("a.stl", text_stl(shapes::cube()).substr(0, 85)), "it ends within a facet; it is cut short");
  EXPECT_EQ(error("a.stl", "solid a\nouter loop\nvertex 0 0 x\n"),
            "line 3: expected three coordinates after \"vertex\", got \"x\"");
  EXPECT_EQ(error("a.stl", "solid a\nvertex 0 0 0\n"),
            "line 2: a facet has more than three vertices, or a vertex is outside a facet");
}

TEST_F(Io, OffTakesItsManySpellings) {
  const std::string body = "0 0 0\n1 0 0\n\n# between\n1 1 0\n0 1 0 # here\n4 0 1 2 3\n3 0 1 2 255 0 0\n";
  for (const char* head : {"OFF\n4 2 0\n", "OFF 4 2 5\n", "# first\nOFF # kind\n\n4 2\n"}) {
    const PolygonSoup soup = parse("a.off", head + body);
    EXPECT_EQ(soup.vertices[3], Vec3(0, 1, 0));
    EXPECT_EQ(soup.loop_start, (Array<std::int32_t>{0, 4}));
    EXPECT_EQ(soup.loops, (Array<std::int32_t>{0, 1, 2, 3, 0, 1, 2}));
  }
  EXPECT_EQ(parse("b.off", "STCNOFF\n1 0 0\n1 2 3 0 0 1 255 0 0 255 0.5 0.5\n").vertices[0], Vec3(1, 2, 3));
}

TEST_F(Io, DamagedOffIsNamed) {
  EXPECT_NE(error("a.off", "4 2 0\n").find("does not begin with \"OFF\""), std::string::npos);
  EXPECT_NE(error("a.off", "4OFF\n").find("not in three dimensions"), std::string::npos);
  EXPECT_NE(error("a.off", "OFF BINARY\n").find("binary OFF file"), std::string::npos);
  EXPECT_EQ(error("a.off", "OFF\n3 x 0\n"), "line 2: expected the number of vertices and of faces");
  EXPECT_NE(error("a.off", "OFF\n3 4000000 0\n0 0 0\n").find("promises 3 vertices and 4000000 faces"),
            std::string::npos);
  EXPECT_EQ(error("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n"),
            "it ends where face 0 should be; it is cut short or damaged");
  EXPECT_EQ(error("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n"),
            "line 6: expected 3 vertices for face 0, got \"\"");
  EXPECT_EQ(error("a.off", "OFF\n1 1 0\n0 0 y\n3 0 0 0\n"),
            "line 3: expected three coordinates for vertex 0, got \"y\"");
}

TEST_F(Io, AFileThatIsNoMeshIsNamed) {
  const auto message = [](const fs::path& path) { return message_of<FileError>([&] { load(path); }); };
  EXPECT_EQ(message(folder_ / "none.ply"), (folder_ / "none.ply").string() + ": there is no such file");
  fs::create_directory(folder_ / "folder.obj");
  EXPECT_NE(message(folder_ / "folder.obj").find("it is a folder"), std::string::npos);
  EXPECT_NE(message(file("a.xyz", "1 2 3")).find("PLY, OBJ, STL and OFF files can be read"), std::string::npos);
  EXPECT_NE(message(file("noextension", "1 2 3")).find("PLY, OBJ, STL and OFF"), std::string::npos);
  for (const char* name : {"e.ply", "e.obj", "e.stl", "e.off"})
    EXPECT_EQ(message(file(name, "")), (folder_ / name).string() + ": it is empty");
  Job cancelled;
  cancelled.cancel();
  EXPECT_THROW(read_polygons(file("a.off", "OFF\n0 0 0\n"), cancelled), Cancelled);
}

TEST_F(Io, NamesMayHaveAnyLetters) {  // where the system's code page lacks them, path.string() throws
  const std::u8string stem = u8"Größe \u6f22\u5b57 \U0001F3E0", missing = u8"\u6f22.ply";
  for (const char* extension : {".ply", ".obj"}) {
    fs::path path = folder_ / stem;
    path += extension;
    save(path, kHouse);
    expect_same(load(path), kHouse);
  }
  EXPECT_EQ(files_in_folder(), 2);
  EXPECT_NE(message_of<FileError>([&] { load(folder_ / missing); }).find(std::string(missing.begin(), missing.end())),
            std::string::npos);
}

TEST_F(Io, EveryFileCutShortIsReadOrNamed) {
  save(folder_ / "whole.ply", kHouse);
  save(folder_ / "whole.obj", kHouse);
  const auto bytes_of = [&](const char* name) {
    std::ostringstream bytes;
    bytes << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    return bytes.str();
  };
  const std::vector<std::pair<std::string, std::string>> files{
      {"cut.ply", bytes_of("whole.ply")},
      {"cut.obj", bytes_of("whole.obj")},
      {"cut.stl", binary_stl(shapes::cube())},
      {"text.stl", text_stl(shapes::cube())},
      {"cut.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2 255 0 0\n"},
      {"text.ply", "ply\nformat ascii 1.0\n" + kPlyHead + "0 0 0\n1 0 0\n0 1e0 -0.5\n3 0 1 2\n"},
      {"columns.ply", kPlyOfColumns},
      {"columns.obj", kObjOfColumns}};
  int refused = 0;
  for (const auto& [name, bytes] : files)
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 200) {
      try {
        Columns columns;
        columns.names = {"red"};
        parse(name, bytes.substr(0, length), name.starts_with("columns") ? &columns : nullptr);
      } catch (const FileError&) {
        ++refused;
      }
    }
  EXPECT_GT(refused, 600);
}

}  // namespace
}  // namespace isimp
