#include <fumarole/asset/mesh_file.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

std::string problem(const fs::path& file)
{
    try {
        asset::load_mesh(file);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

double area(const Mesh& mesh)
{
    double sum = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const glm::dvec3 a(mesh.positions[mesh.triangles[i]]);
        const glm::dvec3 b(mesh.positions[mesh.triangles[i + 1]]);
        const glm::dvec3 c(mesh.positions[mesh.triangles[i + 2]]);
        sum += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return sum;
}

// Positive where triangles wind counter-clockwise seen from outside.
double volume(const Mesh& mesh)
{
    double sum = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const glm::dvec3 a(mesh.positions[mesh.triangles[i]]);
        const glm::dvec3 b(mesh.positions[mesh.triangles[i + 1]]);
        const glm::dvec3 c(mesh.positions[mesh.triangles[i + 2]]);
        sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return sum;
}

void expect_sound(const Mesh& mesh)
{
    ASSERT_FALSE(mesh.triangles.empty());
    ASSERT_EQ(mesh.triangles.size() % 3, 0u);
    ASSERT_EQ(mesh.positions.size(), mesh.normals.size());
    EXPECT_LT(*std::max_element(mesh.triangles.begin(), mesh.triangles.end()),
              mesh.positions.size());
    for (const glm::vec3& normal : mesh.normals)
        EXPECT_NEAR(glm::length(normal), 1, 1e-5);
}

// Every normal is on the side from which the triangle winds counter-clockwise.
void expect_normals_agree(const Mesh& mesh)
{
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const glm::vec3 a = mesh.positions[mesh.triangles[i]];
        const glm::vec3 b = mesh.positions[mesh.triangles[i + 1]];
        const glm::vec3 c = mesh.positions[mesh.triangles[i + 2]];
        for (std::size_t corner = 0; corner < 3; ++corner)
            EXPECT_GT(glm::dot(glm::cross(b - a, c - a), mesh.normals[mesh.triangles[i + corner]]),
                      0);
    }
}

constexpr std::string_view kCube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                   "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                   "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n"
                                   "f 4 1 5 8\n";

constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string base64(const std::string& bytes)
{
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8U |
                    (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k > bytes.size() ? '=' : kBase64[group >> (18 - 6 * k) & 63U];
    }
    return out;
}

std::string float_bytes(const std::vector<float>& values)
{
    std::string bytes(values.size() * sizeof(float), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

std::string ply(const std::string& format, const std::string& body)
{
    return "ply\nformat " + format +
           " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
           body;
}

// The triangle (0 0 5), (2 0 5), (2 3 5).
std::string binary_ply_body(bool big_endian)
{
    const auto swapped = [&](std::string bytes) {
        for (std::size_t i = 0; big_endian && i < bytes.size(); i += 4)
            std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                         bytes.begin() + static_cast<std::ptrdiff_t>(i + 4));
        return bytes;
    };
    const std::int32_t corners[] = {0, 1, 2};
    std::string indices(sizeof(corners), '\0');
    std::memcpy(indices.data(), corners, sizeof(corners));
    return swapped(float_bytes({0, 0, 5, 2, 0, 5, 2, 3, 5})) + '\3' + swapped(indices);
}

// A glTF file with one mesh and the nodes of the caller. `mode` as of the format: 4 triangles.
std::string gltf(const std::vector<float>& positions, const std::string& nodes, int mode = 4,
                 const std::string& more = "")
{
    const std::string bytes = float_bytes(positions);
    return R"({"asset": {"version": "2.0"}, )" + more +
           R"("scene": 0, "scenes": [{"nodes": [0]}], "nodes": )" + nodes +
           R"(, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": )" +
           std::to_string(mode) +
           R"(}]}], "accessors": [{"bufferView": 0, "componentType": 5126,)" + R"( "count": )" +
           std::to_string(positions.size() / 3) +
           R"(, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}],)" +
           R"( "bufferViews": [{"buffer": 0, "byteLength": )" + std::to_string(bytes.size()) +
           R"(}], "buffers": [{"byteLength": )" + std::to_string(bytes.size()) +
           R"(, "uri": "data:application/octet-stream;base64,)" + base64(bytes) + R"("}]})";
}

const std::vector<float> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

TEST(MeshFile, CutsPolygonsIntoTriangles)
{
    const TempFolder folder;
    const Mesh cube = asset::load_mesh(folder.write("cube.obj", kCube));
    expect_sound(cube);
    EXPECT_EQ(cube.triangles.size(), 36u);
    EXPECT_NEAR(area(cube), 6, 1e-6);
    EXPECT_NEAR(volume(cube), 1, 1e-6);
    // Its edges are sharper than what is smoothed: each corner has three normals.
    EXPECT_EQ(cube.positions.size(), 24u);
    expect_normals_agree(cube);

    // A concave polygon: a fan from its first corner would leave it.
    const Mesh ell = asset::load_mesh(folder.write(
        "ell.obj", "v 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4 5 6\n"));
    EXPECT_EQ(ell.triangles.size(), 12u);
    EXPECT_NEAR(area(ell), 3, 1e-6);
}

TEST(MeshFile, SmoothsShallowEdges)
{
    const TempFolder folder;
    // Two triangles that meet at 20 degrees.
    const Mesh roof = asset::load_mesh(
        folder.write("roof.obj", "v 0 0 0\nv 0 1 0\nv 1 0 0\nv -0.94 0 0.342\nf 1 3 2\nf 1 2 4\n"));
    expect_sound(roof);
    EXPECT_EQ(roof.positions.size(), 4u);
}

TEST(MeshFile, KeepsNormalsThatTheFileHas)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 3 4\nf 1//1 2//1 3//1\n"));
    expect_sound(mesh);
    for (const glm::vec3& normal : mesh.normals)
        EXPECT_NEAR(glm::length(normal - glm::vec3(0, 0.6f, 0.8f)), 0, 1e-6);
}

TEST(MeshFile, MakesNormalsWhereTheFileHasZeroes)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n"));
    expect_sound(mesh);
    EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
}

TEST(MeshFile, ReadsPlyOfEveryEncoding)
{
    const TempFolder folder;
    for (const std::string& bytes : {ply("ascii", "0 0 5\n2 0 5\n2 3 5\n3 0 1 2\n"),
                                     ply("binary_little_endian", binary_ply_body(false)),
                                     ply("binary_big_endian", binary_ply_body(true))}) {
        const Mesh mesh = asset::load_mesh(folder.write("t.ply", bytes));
        expect_sound(mesh);
        EXPECT_NEAR(area(mesh), 3, 1e-6);
        EXPECT_EQ(mesh.positions[0], glm::vec3(0, 0, 5));
        EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
    }
}

TEST(MeshFile, ReadsPlyPolygonsAndSkipsWhatElseIsThere)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(folder.write(
        "l.ply", "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 6\r\n"
                 "property uchar red\r\nproperty double x\r\nproperty double y\r\n"
                 "property double z\r\nelement edge 1\r\nproperty int vertex1\r\n"
                 "element face 2\r\nproperty list uchar float weight\r\n"
                 "property list uchar uint vertex_index\r\nend_header\r\n"
                 "255 1 1 0\r\n0 1 2 0\r\n0 0 2 0\r\n0 0 0 0\r\n0 2 0 0\r\n0 2 1 0\r\n7\r\n"
                 "2 0.5 0.5 6 0 1 2 3 4 5\r\n0 2 0 1\r\n"));
    expect_sound(mesh);
    EXPECT_NEAR(area(mesh), 3, 1e-6);
}

TEST(MeshFile, AppliesNodeTransformsAndSwapsNoAxis)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("t.gltf", gltf(kTriangle, R"([{"translation": [10, 20, 30], "children": [1]},
                                      {"scale": [2, 3, 4], "mesh": 0}])")));
    expect_sound(mesh);
    EXPECT_NEAR(area(mesh), 3, 1e-5);
    glm::vec3 high(-1e9f);
    glm::vec3 low(1e9f);
    for (const glm::vec3& p : mesh.positions) {
        high = glm::max(high, p);
        low = glm::min(low, p);
    }
    EXPECT_EQ(low, glm::vec3(10, 20, 30));
    EXPECT_EQ(high, glm::vec3(12, 23, 30));
    EXPECT_NEAR(glm::length(mesh.normals[0] - glm::vec3(0, 0, 1)), 0, 1e-6);
}

TEST(MeshFile, DrawsAMeshOnceForEachNode)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("t.gltf", gltf(kTriangle, R"([{"children": [1, 2, 3]}, {"mesh": 0},
                     {"mesh": 0, "translation": [5, 0, 0]},
                     {"mesh": 0, "rotation": [0.70710678, 0, 0, 0.70710678]}])")));
    expect_sound(mesh);
    EXPECT_EQ(mesh.triangles.size(), 9u);
    EXPECT_NEAR(area(mesh), 1.5, 1e-5);
    // A quarter turn about x takes +z to -y.
    EXPECT_NEAR(glm::length(mesh.normals[mesh.triangles[6]] - glm::vec3(0, -1, 0)), 0, 1e-6);
}

// A glTF file of two meshes, of material 0 and, twice as wide, of material 1.
std::string gltf_of_materials(const std::string& materials)
{
    std::string text =
        gltf(kTriangle, R"([{"children": [1, 2]}, {"mesh": 0}, {"mesh": 1, "scale": [2, 2, 2]}])",
             4, "\"materials\": " + materials + ", ");
    const std::string end = R"("mode": 4}]}])";
    return text.replace(text.find(end), end.size(),
                        R"("mode": 4, "material": 0}]}, {"primitives": [{"attributes": )"
                        R"({"POSITION": 0}, "mode": 4, "material": 1}]}])");
}

TEST(MeshFile, HasTheFactorsOfTheLargestPartsMaterial)
{
    const TempFolder folder;
    const Mesh mesh =
        asset::load_mesh(folder.write("t.gltf", gltf_of_materials(R"([{"name": "small"},
        {"name": "large", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.25, 1],
         "metallicFactor": 0.75, "roughnessFactor": 0.3}, "emissiveFactor": [0.5, 0.25, 1]}])")));
    ASSERT_TRUE(mesh.material.has_value());
    EXPECT_EQ(mesh.material->albedo, glm::vec3(0.8f, 0.5f, 0.25f));
    EXPECT_EQ(mesh.material->gloss, (Gloss{.roughness = 0.3f, .metallic = 0.75f}));
    EXPECT_EQ(mesh.material->emission, glm::vec3(0.5f, 0.25f, 1));
    EXPECT_EQ(mesh.notes,
              (std::vector<std::string>{
                  "has 2 materials; all of it gets that of its largest part, 'large'"}));
}

TEST(MeshFile, AFactorThatAMaterialLeavesOutIsGltfs)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("t.gltf", gltf_of_materials(R"([{"name": "small"}, {"name": "large"}])")));
    EXPECT_EQ(mesh.material,
              (MeshMaterial{glm::vec3(1), {.roughness = 1, .metallic = 1}, glm::vec3(0)}));
    EXPECT_EQ(
        asset::load_mesh(folder.write("b.gltf", gltf(kTriangle, R"([{"mesh": 0}])"))).material,
        std::nullopt);
    EXPECT_EQ(asset::load_mesh(folder.write("c.obj", std::string(kCube))).material, std::nullopt);
}

TEST(MeshFile, SaysThatTexturesAreNotRead)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(folder.write(
        "t.gltf", gltf_of_materials(R"([{"name": "small"}, {"name": "large", "pbrMetallicRoughness":
         {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
         "images": [{"uri": "wood.png"}])")));
    ASSERT_EQ(mesh.notes.size(), 2u);
    EXPECT_EQ(mesh.notes[1], "textures of material 'large' are not read, its factors alone are");
}

TEST(MeshFile, MirroredNodesStayRightSideOut)
{
    const TempFolder folder;
    // A tetrahedron, normals made by the reader; then mirrored and stretched.
    const std::vector<float> tetrahedron = {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                            0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const Mesh plain =
        asset::load_mesh(folder.write("p.gltf", gltf(tetrahedron, R"([{"mesh": 0}])")));
    EXPECT_NEAR(volume(plain), 1.0 / 6, 1e-6);
    const Mesh mirrored = asset::load_mesh(
        folder.write("m.gltf", gltf(tetrahedron, R"([{"mesh": 0, "scale": [-2, 1, 3]}])")));
    expect_sound(mirrored);
    EXPECT_NEAR(volume(mirrored), 1, 1e-5);
    expect_normals_agree(mirrored);
}

TEST(MeshFile, UnrollsStripsAndFans)
{
    const TempFolder folder;
    const std::vector<float> strip = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const Mesh from_strip =
        asset::load_mesh(folder.write("s.gltf", gltf(strip, R"([{"mesh": 0}])", 5)));
    EXPECT_NEAR(area(from_strip), 1, 1e-6);
    for (const glm::vec3& normal : from_strip.normals)
        EXPECT_NEAR(normal.z, 1, 1e-6);
    const std::vector<float> fan = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const Mesh from_fan =
        asset::load_mesh(folder.write("f.gltf", gltf(fan, R"([{"mesh": 0}])", 6)));
    EXPECT_NEAR(area(from_fan), 1, 1e-6);
}

TEST(MeshFile, LeavesOutPointsLinesAndFlatTriangles)
{
    const TempFolder folder;
    const Mesh mesh = asset::load_mesh(
        folder.write("l.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nv 2 0 0\nl 1 4\np 4\nf 1 2 3\n"
                              "f 1 2 5\n"));
    expect_sound(mesh);
    EXPECT_EQ(mesh.triangles.size(), 3u);
}

struct BadMesh {
    const char* name;
    const char* file;
    std::string bytes;
    const char* expected;
};

void PrintTo(const BadMesh& item, std::ostream* out)
{
    *out << item.name;
}

std::vector<BadMesh> bad_meshes()
{
    const float nan = std::nanf("");
    return {
        {"empty_obj", "a.obj", "", "cannot be read as a mesh"},
        {"unknown", "a.xyz123", "hello", "cannot be read as a mesh"},
        {"only_points", "a.obj", "v 0 0 0\nv 1 0 0\np 1 2\n", "has no triangle"},
        {"only_lines", "a.gltf", gltf({0, 0, 0, 1, 0, 0}, R"([{"mesh": 0}])", 1),
         "has no triangle"},
        {"flat", "a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "has no triangle"},
        {"no_node", "a.gltf", gltf(kTriangle, R"([{"name": "alone"}])"), "has no triangle"},
        {"nan", "a.gltf", gltf({0, 0, 0, 1, 0, 0, 0, nan, 0}, R"([{"mesh": 0}])"), "not finite"},
        {"nan_obj", "a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "not finite"},
        {"overflow", "a.gltf",
         gltf({0, 0, 0, 3e38f, 0, 0, 0, 1, 0}, R"([{"mesh": 0, "scale": [1000, 1, 1]}])"),
         "not finite"},
        {"draco", "a.gltf",
         gltf(kTriangle, R"([{"mesh": 0}])", 4,
              R"("extensionsRequired": ["KHR_draco_mesh_compression"], )"),
         "KHR_draco_mesh_compression"},
        {"quantized", "a.GLTF",
         gltf(kTriangle, R"([{"mesh": 0}])", 4,
              R"("extensionsRequired": ["KHR_mesh_quantization"], )"),
         "KHR_mesh_quantization"},
        {"cut_gltf", "a.gltf", gltf(kTriangle, R"([{"mesh": 0}])").substr(0, 200), "cut short"},
        {"cut_glb", "a.glb", std::string("glTF\2\0\0\0\0\1\0\0\20\0\0\0JSON", 20), "truncated"},
        {"short_glb", "a.glb", "glTF", "truncated"},
        {"cut_ply_header", "a.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n",
         "truncated: its PLY header"},
        {"cut_ply", "a.ply", ply("ascii", "0 0 5\n2 0 5\n2 3 5\n3 0 1"), "truncated: ends before"},
        {"cut_binary_ply", "a.ply",
         ply("binary_little_endian", binary_ply_body(false).substr(0, 48)),
         "truncated: ends before"},
        {"ply_index", "a.ply", ply("ascii", "0 0 5\n2 0 5\n2 3 5\n3 0 1 3"), "names vertex 3 of 3"},
        {"ply_negative", "a.ply", ply("ascii", "0 0 5\n2 0 5\n2 3 5\n3 0 1 -1"), "negative"},
        {"ply_word", "a.ply", ply("ascii", "0 0 5\n2 zero 5\n2 3 5\n3 0 1 2"), "'zero'"},
        {"ply_nan", "a.ply", ply("ascii", "0 0 5\n2 nan 5\n2 3 5\n3 0 1 2"), "not finite"},
        {"ply_line", "a.ply", ply("ascii", "0 0 5\n2 0 5\n2 3 5\n2 0 1"), "has no triangle"},
        {"ply_promise", "a.ply",
         "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n"
         "property float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
         "truncated"},
        {"no_ply", "a.ply", "hello", "is no PLY"},
    };
}

class BadMeshFile : public testing::TestWithParam<BadMesh> {};

TEST_P(BadMeshFile, IsRefusedInOneLine)
{
    const TempFolder folder;
    const fs::path file = folder.write(GetParam().file, GetParam().bytes);
    const std::string message = problem(file);
    EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
    EXPECT_NE(message.find(GetParam().expected), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(All, BadMeshFile, testing::ValuesIn(bad_meshes()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(MeshFile, NamesAFileThatIsNotThere)
{
    const TempFolder folder;
    EXPECT_NE(problem(folder.path() / "gone.obj").find("gone.obj: no such"), std::string::npos);
    EXPECT_NE(problem(folder.path()).find("not a file"), std::string::npos);
}

TEST(MeshFile, RefusesABufferThatIsCutShort)
{
    const TempFolder folder;
    std::string text = gltf(kTriangle, R"([{"mesh": 0}])");
    const std::size_t uri = text.find("data:");
    text = text.substr(0, uri) + "t.bin\"}]}";
    folder.write("t.bin", float_bytes(kTriangle).substr(0, 20));
    EXPECT_NE(problem(folder.write("t.gltf", text)), "");
    folder.write("t.bin", float_bytes(kTriangle));
    EXPECT_EQ(problem(folder.write("t.gltf", text)), "");
    fs::remove(folder.path() / "t.bin");
    EXPECT_NE(problem(folder.path() / "t.gltf"), "");
}

fs::path external_mesh(const std::string& name)
{
    return fs::path(FUM_TEST_SHARED) / "vdb" / "external" / "mesh" / name;
}

struct ForeignMesh {
    const char* file;
    std::size_t triangles;
    double area;  // 0: not checked
};

TEST(MeshFile, ReadsMeshesOfOtherPeople)
{
    if (!fs::exists(external_mesh("BoxTextured.glb")))
        GTEST_SKIP() << "no meshes in " << external_mesh("");
    for (const ForeignMesh& mesh :
         {ForeignMesh{"BoxTextured.glb", 12, 6}, ForeignMesh{"WusonOBJ.obj", 3732, 0},
          ForeignMesh{"concave_polygon.obj", 64, 0}, ForeignMesh{"cube_usemtl.obj", 12, 6},
          ForeignMesh{"Mesh_PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2, 1},
          ForeignMesh{"Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2, 1},
          ForeignMesh{"Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2, 1}}) {
        SCOPED_TRACE(mesh.file);
        const Mesh loaded = asset::load_mesh(external_mesh(mesh.file));
        expect_sound(loaded);
        EXPECT_EQ(loaded.triangles.size(), 3 * mesh.triangles);
        EXPECT_TRUE(mesh.area == 0 || std::abs(area(loaded) - mesh.area) < 1e-5);
    }
    for (const char* name : {"00", "01", "02", "03", "07"}) {
        const std::string file =
            std::string("Mesh_PrimitiveMode/Mesh_PrimitiveMode_") + name + ".gltf";
        EXPECT_NE(problem(external_mesh(file)).find("has no triangle"), std::string::npos) << file;
    }
    EXPECT_NE(problem(external_mesh("bunny_draco.glb")).find("KHR_draco_mesh_compression"),
              std::string::npos);
}

TEST(MeshFile, SurvivesEveryPrefix)
{
    const TempFolder folder;
    const std::string text = gltf(kTriangle, R"([{"mesh": 0}])");
    for (const auto& [name, bytes] :
         {std::pair{"p.ply", ply("ascii", "0 0 5\n2 0 5\n2 3 5\n3 0 1 2\n")},
          std::pair{"p.ply", ply("binary_big_endian", binary_ply_body(true))},
          std::pair{"p.gltf", text}, std::pair{"p.obj", std::string(kCube)}}) {
        for (std::size_t length = 0; length < bytes.size(); ++length)
            problem(folder.write(name, bytes.substr(0, length)));  // Error or a part of the mesh
    }
    const fs::path box = external_mesh("BoxTextured.glb");
    if (fs::exists(box)) {
        const std::string bytes = test::read_bytes(box);
        for (std::size_t length = 0; length < bytes.size(); length += 13)
            EXPECT_NE(problem(folder.write("p.glb", bytes.substr(0, length))), "") << length;
    }
}

}  // namespace
}  // namespace fumarole
