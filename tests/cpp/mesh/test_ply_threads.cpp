#include <bit>
#include <filesystem>
#include <fstream>

#include "isimp/mesh/io.h"
#include "mesh_checks.h"
#include "tests.h"

/// Binary PLY files large enough that threads share them: the arrays and the messages are right for any number of
/// threads.
namespace isimp {
namespace {

using checks::raw;

namespace fs = std::filesystem;

constexpr std::int32_t kVertices = 40'000, kFaces = 60'000;  // some pieces of 2^14 rows for each of three threads

PolygonSoup vertices_only(std::int32_t count = kVertices) {
  PolygonSoup soup;
  for (std::int32_t v = 0; v < count; ++v) soup.vertices.emplace_back(v, -0.5F * static_cast<float>(v), 1.0F / (v + 1));
  return soup;
}

void add_polygon(PolygonSoup& soup, std::int32_t corners) {
  soup.loop_start.push_back(static_cast<std::int32_t>(soup.loops.size()));
  const auto n = static_cast<std::int32_t>(soup.vertices.size());
  for (std::int32_t k = 0; k < corners; ++k)
    soup.loops.push_back(static_cast<std::int32_t>((7919 * soup.loops.size() + 13) % static_cast<std::size_t>(n)));
}

PolygonSoup triangles() {
  PolygonSoup soup = vertices_only();
  for (std::int32_t f = 0; f < kFaces; ++f) add_polygon(soup, 3);
  return soup;
}

/// The form in which a file is written.
struct Form {
  bool big = false;
  std::string vertex_before, vertex_after;  ///< properties, and the bytes of each row
  std::string vertex_bytes_before, vertex_bytes_after;
  std::string face_before, face_after;
  std::string face_bytes_before, face_bytes_after;
};

Form big_endian() {
  Form form;
  form.big = true;
  return form;
}

std::string head(const PolygonSoup& soup, const Form& form) {
  return std::string("ply\nformat binary_") + (form.big ? "big" : "little") + "_endian 1.0\nelement vertex " +
         std::to_string(soup.vertices.size()) + "\n" + form.vertex_before +
         "property float x\nproperty float y\nproperty float z\n" + form.vertex_after + "element face " +
         std::to_string(soup.polygon_count()) + "\n" + form.face_before + "property list uchar int vertex_indices\n" +
         form.face_after + "end_header\n";
}

std::string written(const PolygonSoup& soup, const Form& form = {}) {
  std::string bytes = head(soup, form);
  for (const Vec3& p : soup.vertices) {
    bytes += form.vertex_bytes_before;
    for (const double x : p) bytes += raw(static_cast<float>(x), form.big);
    bytes += form.vertex_bytes_after;
  }
  for (std::int32_t q = 0; q < soup.polygon_count(); ++q) {
    bytes += form.face_bytes_before;
    bytes += static_cast<char>(soup.polygon(q).size());
    for (const std::int32_t v : soup.polygon(q)) bytes += raw(v, form.big);
    bytes += form.face_bytes_after;
  }
  return bytes;
}

class PlyThreads : public checks::InFolder {
 protected:
  fs::path save(const std::string& bytes) const {
    std::ofstream(folder_ / "a.ply", std::ios::binary) << bytes;
    return folder_ / "a.ply";
  }
  void expect_read(const std::string& bytes, const PolygonSoup& wanted) const {
    const fs::path path = save(bytes);
    for (const std::int32_t threads : {1, 2, 3}) {
      const PolygonSoup soup = read_polygons(path, job(), threads);
      EXPECT_TRUE(soup.vertices == wanted.vertices) << threads;
      EXPECT_TRUE(soup.loops == wanted.loops) << threads;
      EXPECT_TRUE(soup.loop_start == wanted.loop_start) << threads;
    }
  }
  void expect_error(const std::string& bytes, const std::string& wanted) const {
    const fs::path path = save(bytes);
    for (const std::int32_t threads : {1, 2, 3})
      EXPECT_EQ(message_of<FileError>([&] { read_polygons(path, job(), threads); }), path.string() + ": " + wanted);
  }
};

/// Vertices that a float holds exactly.
PolygonSoup rounded(PolygonSoup soup) {
  for (Vec3& p : soup.vertices) p = p.cast<float>().cast<double>();
  return soup;
}

TEST_F(PlyThreads, TrianglesAreReadBackInEitherByteOrder) {
  const PolygonSoup soup = rounded(triangles());
  expect_read(written(soup), soup);
  expect_read(written(soup, big_endian()), soup);
}

TEST_F(PlyThreads, StretchesOfEqualPolygonsBetweenOthersAreReadBack) {
  PolygonSoup soup = rounded(vertices_only());
  const auto stretch = [&](std::int32_t count, std::int32_t corners) {
    for (std::int32_t q = 0; q < count; ++q) add_polygon(soup, corners);
  };
  stretch(20'000, 3);
  stretch(1, 5);
  stretch(40'000, 4);
  for (std::int32_t q = 0; q < 3000; ++q) stretch(1, q % 6);  // polygons without corners among them
  stretch(20'000, 3);
  stretch(2, 0);
  expect_read(written(soup), soup);
  expect_read(written(soup, big_endian()), soup);
}

TEST_F(PlyThreads, OtherPropertiesAreSkipped) {
  const PolygonSoup soup = rounded(triangles());
  Form form;
  form.vertex_before = "property uchar red\nproperty double when\n";
  form.vertex_bytes_before = std::string(9, '\7');
  form.vertex_after = "property short tag\n";
  form.vertex_bytes_after = std::string(2, '\1');
  form.face_before = "property float quality\n";
  form.face_bytes_before = std::string(4, '\3');
  form.face_after = "property uchar red\nproperty uint id\n";
  form.face_bytes_after = std::string(5, '\3');
  expect_read(written(soup, form), soup);
  Form lists;  // rows with unknown beginnings
  lists.vertex_after = "property list uchar short tags\n";
  lists.vertex_bytes_after = std::string("\2\0\0\0\0", 5);
  lists.face_after = "property list uchar float texcoord\n";
  lists.face_bytes_after = std::string("\1\0\0\0\0", 5);
  expect_read(written(soup, lists), soup);
}

TEST_F(PlyThreads, EveryTypeOfNumberIsRead) {
  const std::array<const char*, 6> types{"char", "uchar", "short", "ushort", "int", "uint"};
  const std::array<std::size_t, 6> sizes{1, 1, 2, 2, 4, 4};
  const auto number = [](int value, std::size_t size) {  // big-endian
    std::string bytes(size, '\0');
    bytes.back() = static_cast<char>(value);
    return bytes;
  };
  for (std::size_t count = 0; count < types.size(); ++count)
    for (std::size_t index = 0; index < types.size(); ++index) {
      std::string bytes = std::string("ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty ") + types[index] +
                          " z\nproperty double x\nproperty " + types[count] + " y\nelement face 2\nproperty list " +
                          types[count] + " " + types[index] + " vertex_index\nend_header\n";
      PolygonSoup wanted;
      for (int v = 0; v < 3; ++v) {
        bytes += number(v + 5, sizes[index]) + raw(0.25 * v, true) + number(v + 7, sizes[count]);
        wanted.vertices.emplace_back(0.25 * v, v + 7, v + 5);
      }
      for (int q = 0; q < 2; ++q) {
        bytes += number(3, sizes[count]) + number(q, sizes[index]) + number(1, sizes[index]) + number(2, sizes[index]);
        wanted.loop_start.push_back(3 * q);
        wanted.loops.insert(wanted.loops.end(), {q, 1, 2});
      }
      expect_read(bytes, wanted);
    }
}

std::string promises(const std::string& element, int rows, std::size_t bytes) {
  return "the header promises " + std::to_string(rows) + " of element \"" + element + "\", but the whole file has " +
         std::to_string(bytes) + " bytes; it is cut short or damaged";
}

std::string ends_within(const std::string& element, std::size_t row, int rows) {
  return "it ends within " + element + " " + std::to_string(row) + " (the first is 0) of " + std::to_string(rows) +
         "; it is cut short or damaged";
}

TEST_F(PlyThreads, AFileCutAtAnyByteNamesTheRowItEndsIn) {
  constexpr int kFew = 5, kMore = 6;
  PolygonSoup soup = vertices_only(kFew);
  for (int q = 0; q < kMore; ++q) add_polygon(soup, 3);
  const std::string bytes = written(soup);
  const std::size_t body = head(soup, {}).size(), faces = body + std::size_t{12} * kFew;
  const auto error_at = [&](std::size_t length) {  // a row of faces takes at least the byte of its count
    const bool in_vertices = length < faces;
    const std::size_t left = length - (in_vertices ? body : faces);
    if (in_vertices) return left + 1 < faces - body ? promises("vertex", kFew, length) : ends_within("vertex", 4, kFew);
    const std::size_t row = left / 13, of_row = left % 13;
    if (left + 1 < kMore) return promises("face", kMore, length);
    if (of_row == 0 || of_row > 3)
      return ends_within("face", row, kMore);  // the file holds as many bytes as the list has values
    return "face " + std::to_string(row) +
           " (the first is 0) promises a list of 3 values, more than the file holds; it is damaged";
  };
  for (std::size_t length = body; length < bytes.size(); ++length)
    expect_error(bytes.substr(0, length), error_at(length));
}

TEST_F(PlyThreads, ALongFileCutShortNamesTheRowToo) {
  const std::string bytes = written(triangles());
  const std::size_t faces = bytes.size() - std::size_t{13} * kFaces;
  expect_error(bytes.substr(0, faces + std::size_t{13} * 55'000 + 6), ends_within("face", 55'000, kFaces));
  expect_error(bytes.substr(0, faces - 1), ends_within("vertex", kVertices - 1, kVertices));
  expect_error(bytes.substr(0, faces - 12'000), promises("vertex", kVertices, faces - 12'000));
}

TEST_F(PlyThreads, TheFirstWrongNumberIsNamed) {
  const auto error = [](const std::string& what) {
    return what + ", but there are 40000 vertices, the first of them 0";
  };
  PolygonSoup soup = triangles();
  soup.loops[3 * 58'000] = -1;
  soup.loops[3 * 57'000 + 2] = kVertices;
  expect_error(written(soup), error("face 57000 (the first is 0) uses vertex 40000"));
  soup.loops[3 * 30'000 + 1] = -7;
  expect_error(written(soup), error("face 30000 (the first is 0) uses an impossible vertex"));
  std::string bytes = written(triangles());
  bytes[bytes.size() - std::size_t{13} * 10] = '\xff';  // the corners of a face near the end
  expect_error(bytes,
               "face 59990 (the first is 0) promises a list of 255 values, more than the file holds; it is damaged");
}

TEST_F(PlyThreads, StripsAreReadBackAfterSharedVertices) {
  PolygonSoup soup = rounded(vertices_only());
  std::string bytes = std::string("ply\nformat binary_little_endian 1.0\nelement vertex ") + std::to_string(kVertices) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
                      "property list int int vertex_indices\nend_header\n";
  for (const Vec3& p : soup.vertices)
    for (const double x : p) bytes += raw(static_cast<float>(x), false);
  bytes += raw(kVertices, false);
  for (std::int32_t v = 0; v < kVertices; ++v) {
    bytes += raw(v, false);
    if (v < 2) continue;
    soup.loop_start.push_back(static_cast<std::int32_t>(soup.loops.size()));
    soup.loops.insert(soup.loops.end(), {v % 2 == 0 ? v - 2 : v - 1, v % 2 == 0 ? v - 1 : v - 2, v});
  }
  expect_read(bytes, soup);
}

TEST_F(PlyThreads, ACancelEndsTheReading) {
  const fs::path path = save(written(triangles()));
  for (const int last : {1, 3, 8}) {
    Counting counting(last);
    EXPECT_THROW(read_polygons(path, counting.job, 3), Cancelled) << last;
  }
}

}  // namespace
}  // namespace isimp
