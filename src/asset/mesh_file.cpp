#include <fumarole/asset/mesh_file.h>

#include <algorithm>
#include <array>
#include <assimp/BaseImporter.h>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "asset/ply_check.h"
#include "asset/printable.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

// Edges sharper than this stay edges where normals are made.
constexpr float kSmoothDegrees = 60;

// Vertices are addressed with 32 bits.
constexpr std::size_t kMaxVertices = 0xffffffffU;

// Extensions that change how coordinates are stored. Assimp does not know them and, where it does
// not stop, takes packed bytes for floats.
constexpr std::array<std::string_view, 4> kPackedMeshExtensions = {
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression",
    "KHR_mesh_quantization"};

std::string lower_case(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string read_bytes(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// The JSON of a .gltf or .glb, its container checked; nothing if it is neither.
std::optional<std::string> gltf_json(const fs::path& file)
{
    const std::string extension = lower_case(file.extension().string());
    if (extension != ".gltf" && extension != ".glb")
        return std::nullopt;
    std::string bytes = read_bytes(file);
    if (!bytes.starts_with("glTF"))
        return extension == ".gltf" ? std::optional(std::move(bytes)) : std::nullopt;

    // magic, version, length of all; length of the first chunk, its kind
    constexpr std::size_t kHeaderBytes = 20;
    const auto word = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i]))
                     << (8 * i);
        return value;
    };
    if (bytes.size() < kHeaderBytes)
        fail(file, "truncated: ends within the glTF header");
    const std::size_t total = word(8);
    const std::size_t json_bytes = word(12);
    if (total > bytes.size())
        fail(file, fmt::format("truncated: {} bytes of {}", bytes.size(), total));
    if (json_bytes > bytes.size() - kHeaderBytes)
        fail(file, "damaged: its JSON is longer than the file");
    return bytes.substr(kHeaderBytes, json_bytes);
}

/// Of a glTF file's JSON; checks that its coordinates are not packed. @returns how many materials
/// it has, of which Assimp makes one more for meshes that have none; 0 if the file is no glTF
std::size_t check_gltf(const fs::path& file)
{
    const std::optional<std::string> text = gltf_json(file);
    if (!text)
        return 0;
    const nlohmann::json tree = nlohmann::json::parse(*text, nullptr, false);
    if (!tree.is_object())
        fail(file, "its JSON is damaged or cut short");
    const auto required = tree.find("extensionsRequired");
    if (required != tree.end() && required->is_array())
        for (const nlohmann::json& name : *required)
            for (const std::string_view packed : kPackedMeshExtensions)
                if (name.is_string() && name.get_ref<const std::string&>() == packed)
                    fail(file, fmt::format("its coordinates are packed with {}, which is not "
                                           "supported: export it without mesh compression",
                                           packed));
    const auto materials = tree.find("materials");
    return materials != tree.end() && materials->is_array() ? materials->size() : 0;
}

// What a PLY holds; nothing for other kinds of file.
std::optional<PlyPolygons> ply_polygons(const fs::path& file)
{
    std::array<char, 3> magic{};
    std::ifstream(file, std::ios::binary).read(magic.data(), magic.size());
    const bool is_ply = lower_case(std::string(magic.data(), magic.size())) == "ply";
    if (!is_ply && lower_case(file.extension().string()) != ".ply")
        return std::nullopt;
    std::optional<PlyPolygons> polygons;
    try {
        polygons = read_ply(read_bytes(file));
    } catch (const Error& problem) {
        fail(file, problem.what());
    }
    if (!polygons)
        fail(file, "cannot be read as a mesh: is no PLY file");
    return polygons;
}

// Hands polygons to Assimp, which makes triangles and normals of them, in its PLY reader's stead.
class PolygonsImporter : public Assimp::BaseImporter {
public:
    explicit PolygonsImporter(PlyPolygons polygons) : polygons_(std::move(polygons)) {}

    bool CanRead(const std::string& /*file*/, Assimp::IOSystem* /*io*/,
                 bool /*by_content*/) const override
    {
        return true;
    }

protected:
    const aiImporterDesc* GetInfo() const override
    {
        static const aiImporterDesc info{"PLY", "", "", "", 0, 0, 0, 0, 0, "ply"};
        return &info;
    }

    void InternReadFile(const std::string& /*file*/, aiScene* scene,
                        Assimp::IOSystem* /*io*/) override
    {
        auto mesh = std::make_unique<aiMesh>();
        mesh->mNumVertices = static_cast<unsigned>(polygons_.vertices.size());
        mesh->mVertices = new aiVector3D[mesh->mNumVertices];  // arrays that it owns, as all below
        if (polygons_.has_normals)
            mesh->mNormals = new aiVector3D[mesh->mNumVertices];
        for (unsigned i = 0; i < mesh->mNumVertices; ++i) {
            const auto& [x, y, z, nx, ny, nz] = polygons_.vertices[i];
            mesh->mVertices[i] = {x, y, z};
            if (mesh->mNormals != nullptr)
                mesh->mNormals[i] = {nx, ny, nz};
        }
        mesh->mNumFaces = static_cast<unsigned>(polygons_.faces.size());
        mesh->mFaces = new aiFace[mesh->mNumFaces];
        for (unsigned f = 0; f < mesh->mNumFaces; ++f) {
            const std::vector<std::uint32_t>& corners = polygons_.faces[f];
            aiFace& face = mesh->mFaces[f];
            face.mNumIndices = static_cast<unsigned>(corners.size());
            face.mIndices = new unsigned[corners.size()];
            std::copy(corners.begin(), corners.end(), face.mIndices);
        }
        scene->mNumMeshes = 1;
        scene->mMeshes = new aiMesh* [1] { mesh.release() };
        scene->mRootNode = new aiNode;
        scene->mRootNode->mNumMeshes = 1;
        scene->mRootNode->mMeshes = new unsigned[1]{0};
    }

private:
    PlyPolygons polygons_;
};

const aiScene* read_polygons(Assimp::Importer& importer, PlyPolygons polygons, unsigned steps)
{
    if (Assimp::BaseImporter* own = importer.GetImporter("ply"))
        importer.UnregisterLoader(own);
    importer.RegisterLoader(new PolygonsImporter(std::move(polygons)));  // which it owns
    constexpr std::string_view kAny = "ply";
    return importer.ReadFileFromMemory(kAny.data(), kAny.size(), steps, "ply");
}

glm::dmat4 to_glm(const aiMatrix4x4& m)
{
    return {{m.a1, m.b1, m.c1, m.d1},
            {m.a2, m.b2, m.c2, m.d2},
            {m.a3, m.b3, m.c3, m.d3},
            {m.a4, m.b4, m.c4, m.d4}};
}

glm::dvec3 to_glm(const aiVector3D& v)
{
    return {v.x, v.y, v.z};
}

bool all_finite(const glm::vec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Ends what Assimp does once the program is told to stop.
class StopWhenCancelled : public Assimp::ProgressHandler {
public:
    explicit StopWhenCancelled(const fs::path& file) : file_(file) {}
    bool Update(float /*share*/) override
    {
        try {
            check_cancelled(file_);
        } catch (const LoadCancelled&) {
            return false;
        }
        return true;
    }

private:
    const fs::path& file_;
};

// The triangles of one node's mesh, placed in the file's space.
// @returns their area
double append_mesh(const fs::path& file, const aiMesh& part, const glm::dmat4& file_from_node,
                   Mesh& out)
{
    // Each part holds one kind of primitive: Assimp was asked to sort them.
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0 || part.mNumVertices == 0)
        return 0;
    const std::size_t first = out.positions.size();
    if (first + part.mNumVertices > kMaxVertices)
        fail(file, "more than 2^32 vertices");

    const glm::dmat3 linear(file_from_node);
    // The cofactor matrix carries normals as the inverse transpose does, and exists for scale 0
    // too.
    const glm::dmat3 normal_from_node(glm::cross(linear[1], linear[2]),
                                      glm::cross(linear[2], linear[0]),
                                      glm::cross(linear[0], linear[1]));
    const bool mirrored = glm::determinant(linear) < 0;
    const double normal_sign = mirrored ? -1 : 1;

    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const glm::vec3 position(file_from_node * glm::dvec4(to_glm(part.mVertices[i]), 1));
        if (!all_finite(position))
            fail(file, fmt::format("vertex {} of mesh '{}' is not finite", i,
                                   printable(part.mName.C_Str())));
        out.positions.push_back(position);
        glm::vec3 normal(0);
        if (part.HasNormals()) {
            const glm::dvec3 n = normal_sign * (normal_from_node * to_glm(part.mNormals[i]));
            normal = glm::vec3(n / glm::length(n));
        }
        out.normals.push_back(all_finite(normal) ? normal : glm::vec3(0));
    }

    double total = 0;
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
        const aiFace& face = part.mFaces[f];
        if (face.mNumIndices != 3)
            continue;
        std::array<std::size_t, 3> corner{};
        for (std::size_t i = 0; i < 3; ++i) {
            if (face.mIndices[i] >= part.mNumVertices)
                fail(file, fmt::format("damaged: triangle {} of mesh '{}' names vertex {} of {}", f,
                                       printable(part.mName.C_Str()), face.mIndices[i],
                                       part.mNumVertices));
            corner[i] = first + face.mIndices[i];
        }
        if (mirrored)
            std::swap(corner[1], corner[2]);
        const glm::dvec3 a(out.positions[corner[0]]);
        const glm::dvec3 b(out.positions[corner[1]]);
        const glm::dvec3 c(out.positions[corner[2]]);
        const glm::dvec3 across = glm::cross(b - a, c - a);
        const double area = glm::length(across);
        if (!(area > 0))
            continue;  // nothing to see, and no plane to intersect
        total += 0.5 * area;
        for (const std::size_t i : corner) {
            out.triangles.push_back(static_cast<std::uint32_t>(i));
            if (out.normals[i] == glm::vec3(0))
                out.normals[i] = glm::vec3(across / area);
        }
    }
    return total;
}

glm::vec3 to_glm(const aiColor3D& c)
{
    return {c.r, c.g, c.b};
}

/// The factors of a glTF material, within their ranges.
MeshMaterial factors_of(const aiMaterial& from)
{
    MeshMaterial material;
    aiColor3D color(1, 1, 1);
    from.Get(AI_MATKEY_BASE_COLOR, color);
    material.albedo = glm::clamp(to_glm(color), 0.0f, 1.0f);
    material.gloss = {.roughness = 1, .metallic = 1};  // glTF's defaults
    from.Get(AI_MATKEY_ROUGHNESS_FACTOR, material.gloss.roughness);
    from.Get(AI_MATKEY_METALLIC_FACTOR, material.gloss.metallic);
    material.gloss.roughness = std::clamp(material.gloss.roughness, 0.0f, 1.0f);
    material.gloss.metallic = std::clamp(material.gloss.metallic, 0.0f, 1.0f);
    color = aiColor3D(0, 0, 0);
    from.Get(AI_MATKEY_COLOR_EMISSIVE, color);
    material.emission = glm::max(to_glm(color), 0.0f);
    return material;
}

/// The material of the largest part of a mesh, whose parts' areas are known by their materials'
/// numbers, and what of all of them is not used.
void add_factors(const aiScene& scene, std::size_t materials,
                 const std::map<unsigned, double>& areas, Mesh& mesh)
{
    const auto largest =
        std::max_element(areas.begin(), areas.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (largest == areas.end() ||
        largest->first >= std::min<std::size_t>(materials, scene.mNumMaterials))
        return;
    const aiMaterial& from = *scene.mMaterials[largest->first];
    mesh.material = factors_of(from);
    const std::string name = printable(from.GetName().C_Str());
    if (areas.size() > 1)
        mesh.notes.push_back(fmt::format(
            "has {} materials; all of it gets that of its largest part, '{}'", areas.size(), name));
    for (const aiTextureType type :
         {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE, aiTextureType_METALNESS,
          aiTextureType_DIFFUSE_ROUGHNESS, aiTextureType_UNKNOWN, aiTextureType_EMISSIVE,
          aiTextureType_NORMALS})
        if (from.GetTextureCount(type) > 0) {
            mesh.notes.push_back(
                fmt::format("textures of material '{}' are not read, its factors alone are", name));
            break;
        }
}

}  // namespace

Mesh load_mesh(const fs::path& file)
{
    check_file(file, "mesh file");
    std::error_code error;
    check_memory(file, fs::file_size(file, error));
    const std::size_t materials = check_gltf(file);

    Assimp::Importer importer;
    importer.SetProgressHandler(new StopWhenCancelled(file));  // which it owns
    importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kSmoothDegrees);
    // Without colours and texture coordinates more vertices are identical and join.
    importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                                aiComponent_COLORS | aiComponent_TEXCOORDS |
                                    aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_BONEWEIGHTS |
                                    aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                    aiComponent_LIGHTS | aiComponent_CAMERAS);
    const unsigned steps = aiProcess_RemoveComponent | aiProcess_Triangulate |
                           aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                           aiProcess_JoinIdenticalVertices;
    std::optional<PlyPolygons> ply = ply_polygons(file);
    const aiScene* scene = ply ? read_polygons(importer, std::move(*ply), steps)
                               : importer.ReadFile(file.string(), steps);
    check_cancelled(file);
    if (scene == nullptr)
        fail(file, "cannot be read as a mesh: " + printable(importer.GetErrorString(), 200));

    Mesh mesh;
    std::map<unsigned, double> areas;  // of each material
    std::vector<std::pair<const aiNode*, glm::dmat4>> pending;
    if (scene->mRootNode != nullptr)
        pending.emplace_back(scene->mRootNode, to_glm(scene->mRootNode->mTransformation));
    while (!pending.empty()) {
        const auto [node, file_from_node] = pending.back();
        pending.pop_back();
        for (unsigned i = 0; i < node->mNumMeshes; ++i) {
            const aiMesh& part = *scene->mMeshes[node->mMeshes[i]];
            const double area = append_mesh(file, part, file_from_node, mesh);
            if (area > 0)
                areas[part.mMaterialIndex] += area;
        }
        for (unsigned i = node->mNumChildren; i-- > 0;) {
            const aiNode* child = node->mChildren[i];
            pending.emplace_back(child, file_from_node * to_glm(child->mTransformation));
        }
    }
    if (mesh.triangles.empty())
        fail(file, "has no triangle");
    for (glm::vec3& normal : mesh.normals) {
        if (normal == glm::vec3(0))
            normal = {0, 0, 1};  // of a vertex in no triangle: never seen, but of unit length
    }
    add_factors(*scene, materials, areas, mesh);
    return mesh;
}

}  // namespace fumarole::asset
