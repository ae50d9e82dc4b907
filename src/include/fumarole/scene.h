#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/voxel_grid.h>

// A scene as data: what a scene file states (docs/scene_files.md), and, beside each
// file name, what was read from it. Metres, seconds, linear Rec. 709, right-handed world. Grids,
// meshes and maps are compared by their pointers.

namespace fumarole {

struct Camera {
    enum class Projection { perspective, orthographic };

    glm::dvec3 position{0, -10, 2};  ///< metres
    glm::dvec3 look_at{0, 0, 2};     ///< metres
    glm::dvec3 up{0, 0, 1};
    double vfov_deg = 32;  ///< vertical field of view, (0, 180)
    double near = 0.1;     ///< near plane along the view axis [m], > 0
    double far = 1000;     ///< far plane along the view axis [m], > near
    Projection projection = Projection::perspective;
    /// Height of an orthographic picture in metres; 0: what vfov_deg sees at the distance of
    /// look_at.
    double ortho_height = 0;

    bool operator==(const Camera&) const = default;
};

/// Where a camera is at a time [s].
struct CameraKey {
    double time = 0;
    Camera camera;

    bool operator==(const CameraKey&) const = default;
};

/// A light infinitely far away.
struct SunLight {
    glm::dvec3 direction_to_light{0, 0, 1};  ///< normalised on reading
    glm::vec3 irradiance{1};                 ///< W/m^2, on a plane facing it

    bool operator==(const SunLight&) const = default;
};

struct PointLight {
    glm::dvec3 position{0};          ///< metres
    glm::vec3 radiant_intensity{1};  ///< W/sr; irradiance at distance d is radiant_intensity / d^2

    bool operator==(const PointLight&) const = default;
};

struct SpotLight {
    glm::dvec3 position{0};          ///< metres
    glm::dvec3 direction{0, 0, -1};  ///< axis that it shines along; normalised on reading
    double cone_deg = 45;            ///< full opening angle, (0, 180)
    double blend = 0.15;             ///< share of the cone over which its edge fades, 0..1
    glm::vec3 radiant_intensity{1};  ///< W/sr on the axis

    bool operator==(const SpotLight&) const = default;
};

/// A rectangle that shines evenly to all directions. It is not seen itself, and hides nothing.
struct RectLight {
    glm::dvec3 center{0};  ///< metres
    /// Metres, along the whole of its edges, which are at right angles. One-sided it shines to the
    /// side of -cross(edges[0], edges[1]): down, where they are x and y.
    std::array<glm::dvec3, 2> edges{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)};
    glm::vec3 radiance{1};  ///< W/m^2/sr
    bool two_sided = false;

    bool operator==(const RectLight&) const = default;
};

/// A disk that shines likewise.
struct DiskLight {
    glm::dvec3 center{0};         ///< metres
    glm::dvec3 normal{0, 0, -1};  ///< direction that it shines in; normalised on reading
    double radius = 0.5;          ///< metres, > 0
    glm::vec3 radiance{1};        ///< W/m^2/sr
    bool two_sided = false;

    bool operator==(const DiskLight&) const = default;
};

using Light = std::variant<SunLight, PointLight, SpotLight, RectLight, DiskLight>;

/// How a medium moves while the shutter is open. Reading a scene's files spreads its grids along
/// the way; what a host fills in itself is drawn as it is.
struct MediumMotion {
    enum class Unit { metres_per_second, voxels_per_frame };

    std::string velocity_grid;  ///< vec3 grid (or name.x name.y name.z); "" for none
    /// Unit of velocity: the file's metres, before GridMedium::scale, or the grid's own voxels.
    Unit unit = Unit::metres_per_second;
    double shutter = 0;  ///< time that it is open [frames], centred; 0: nothing is blurred

    bool operator==(const MediumMotion&) const = default;
};

/// A medium from a .vdb file (or from any VoxelGrid that a host fills in).
/// World position of index i: translate + scale * (density->world_from_index * i).
struct GridMedium {
    /// Path, absolute or relative to the working directory. #s stand for a frame's number
    /// (asset/animation.h).
    std::string file;
    std::string grid;           ///< density: name, name[n]; "" for the first fog volume
    std::string emission_grid;  ///< float or vec3 grid; "" for none
    std::string color_grid;  ///< vec3 grid (or name.x name.y name.z) that scales sigma_s and leaves
                             ///< sigma_t; "" for none
    std::string temperature_grid;  ///< float grid; "" for none
    MediumMotion motion;

    std::shared_ptr<const VoxelGrid> density;  ///< vec3: one density per colour channel
    std::shared_ptr<const VoxelGrid> emission;
    std::shared_ptr<const VoxelGrid> color;
    std::shared_ptr<const VoxelGrid> temperature;

    glm::dvec3 translate{0};           ///< metres
    double scale = 1;                  ///< > 0
    glm::vec3 sigma_s_per_density{1};  ///< 1/m per unit of density
    glm::vec3 sigma_a_per_density{0};  ///< 1/m per unit of density
    float g = 0;                       ///< mean cosine of the phase, (-1, 1); > 0 forward
    glm::vec3 emission_per_unit{0};    ///< W/m^2/sr per metre, per unit of the emission grid

    /// Kelvin per unit of the temperature grid; 0: as kelvin_per_unit() finds.
    double temperature_scale = 0;
    /// Over a blackbody's radiance per metre, in the units of docs/scene_files.md; >= 0.
    float blackbody_intensity = 1;
    glm::vec3 blackbody_tint{1};  ///< times the blackbody's colour

    bool operator==(const GridMedium&) const = default;
};

/// Kelvin that a unit of a medium's temperature grid stands for: its temperature_scale, or where
/// that is 0 what the grid's largest value tells: 1000 if it is under 20, as simulators have it
/// that hold 0 to 3, else 1.
FUMAROLE_API double kelvin_per_unit(const GridMedium& medium);

/// Whether some of a medium's temperature grid is hot enough to be seen, and neither its intensity
/// nor its tint is 0.
FUMAROLE_API bool glows_hot(const GridMedium& medium);

struct HomogeneousProfile {
    bool operator==(const HomogeneousProfile&) const = default;
};

/// Coefficients times exp(-(z - z0) / scale_height).
struct ExpHeightProfile {
    double scale_height = 1;  ///< metres, > 0
    double z0 = 0;            ///< metres

    bool operator==(const ExpHeightProfile&) const = default;
};

/// Coefficients times max(0, (fbm - threshold) / (1 - threshold)), fbm in 0..1, at p - time *
/// drift.
struct NoiseProfile {
    double feature_size = 1;  ///< size of the first octave's cells [m], > 0
    int octaves = 5;          ///< 1..16
    double gain = 0.5;        ///< amplitude of an octave over the one before, (0, 1]
    double lacunarity = 2;    ///< frequency of an octave over the one before, >= 1
    double threshold = 0.45;  ///< [0, 1)
    std::uint32_t seed = 0;
    glm::dvec3 drift{0};  ///< metres per second

    bool operator==(const NoiseProfile&) const = default;
};

using Profile = std::variant<HomogeneousProfile, ExpHeightProfile, NoiseProfile>;

struct BoxMedium {
    glm::dvec3 min{0};  ///< metres
    glm::dvec3 max{1};  ///< metres, > min
    Profile profile;
    glm::vec3 sigma_s{0};  ///< 1/m
    glm::vec3 sigma_a{0};  ///< 1/m
    float g = 0;
    glm::vec3 emission{0};  ///< W/m^2/sr per metre, times the profile

    bool operator==(const BoxMedium&) const = default;
};

using Medium = std::variant<GridMedium, BoxMedium>;

/// A surface that reflects as glTF 2.0's metallic-roughness model has it: GGX with alpha =
/// roughness^2, F0 0.04 or, as metallic says, the albedo.
struct Gloss {
    float roughness = 1;  ///< 0..1
    float metallic = 0;   ///< 0..1

    bool operator==(const Gloss&) const = default;
};

/// What a mesh's file says of how it looks: the factors of a glTF material.
struct MeshMaterial {
    glm::vec3 albedo{1};
    Gloss gloss;
    glm::vec3 emission{0};  ///< W/m^2/sr

    bool operator==(const MeshMaterial&) const = default;
};

struct Mesh {
    std::vector<glm::vec3> positions;      ///< metres, as in the file
    std::vector<glm::vec3> normals;        ///< unit length, one a position
    std::vector<std::uint32_t> triangles;  ///< three indices a triangle
    std::optional<MeshMaterial> material;  ///< the file's material, if it is used
    std::vector<std::string> notes;        ///< notes on what of the file is not used
};

struct SphereSurface {
    glm::dvec3 center{0};  ///< metres
    double radius = 1;     ///< metres, > 0
    glm::vec3 albedo{0.5f};
    std::optional<Gloss> gloss = {};  ///< none: Lambertian
    glm::vec3 emission{0};            ///< W/m^2/sr

    bool operator==(const SphereSurface&) const = default;
};

struct BoxSurface {
    glm::dvec3 min{0};  ///< metres
    glm::dvec3 max{1};  ///< metres, > min
    glm::vec3 albedo{0.5f};
    std::optional<Gloss> gloss = {};  ///< none: Lambertian
    glm::vec3 emission{0};            ///< W/m^2/sr

    bool operator==(const BoxSurface&) const = default;
};

/// Which values of a surface are those of its mesh's material, and the defaults where that has
/// none: load_scene_files() fills them in.
struct FromMesh {
    bool albedo = false, roughness = false, metallic = false, emission = false;

    bool operator==(const FromMesh&) const = default;
};

struct MeshSurface {
    std::string file;
    std::shared_ptr<const Mesh> mesh;
    glm::dvec3 translate{0};  ///< metres
    double scale = 1;         ///< > 0
    glm::vec3 albedo{0.5f};
    std::optional<Gloss> gloss = {};  ///< none: Lambertian
    glm::vec3 emission{0};            ///< W/m^2/sr
    FromMesh from_mesh = {};          ///< until its files are loaded

    bool operator==(const MeshSurface&) const = default;
};

/// All surfaces are opaque.
using Surface = std::variant<SphereSurface, BoxSurface, MeshSurface>;

/// A picture with an opacity, linear Rec. 709, whose colour is multiplied by it already (associated
/// alpha): filtered as it is, what shines through at its edges is not darkened.
struct TransparentImage {
    int width = 0;
    int height = 0;
    std::vector<glm::vec4> texels;  ///< row by row from the top
};

/// What a source or what is behind it is multiplied with when it is blended: OpenGL's.
enum class BlendFactor {
    zero,
    one,
    src_color,
    one_minus_src_color,
    dst_color,
    one_minus_dst_color,
    src_alpha,
    one_minus_src_alpha,
    dst_alpha,
    one_minus_dst_alpha,
    src_alpha_saturate,  ///< min(source alpha, 1 - destination alpha); 1 for alpha itself
};

/// How a transparent is laid over what is behind it.
struct Blend {
    enum class Kind {
        alpha,          ///< radiance * alpha + behind * (1 - alpha)
        premultiplied,  ///< radiance + behind * (1 - alpha)
        add,            ///< radiance + behind
        multiply,       ///< behind * filter
        factors,        ///< radiance * source + behind * destination
    };
    Kind kind = Kind::alpha;
    BlendFactor source = BlendFactor::one;                       ///< Kind::factors
    BlendFactor destination = BlendFactor::one_minus_src_alpha;  ///< Kind::factors

    bool operator==(const Blend&) const = default;
};

/// What is seen of a transparent. It is unlit, throws no light, and is seen by the eye alone unless
/// it casts.
struct TransparentLook {
    Blend blend;
    glm::vec3 radiance{0};   ///< W/m^2/sr; where there is an image, that says it
    glm::vec3 filter{1};     ///< Kind::multiply: what it lets through, likewise
    float alpha = 1;         ///< opacity, 0..1; multiplies an image's own
    std::string image_file;  ///< path, #s for a frame's number (asset/animation.h); "" for none
    std::shared_ptr<const TransparentImage> image;  ///< over the whole of a quad or a billboard
    float scale = 1;                                ///< radiance of the image's 1 [W/m^2/sr]
    /// Distance before a surface, along the ray [m], over which it fades to nothing; 0: none.
    float depth_fade = 0;
    /// True if it filters the light of lights on its way to media and surfaces too, as it does what
    /// the eye sees behind it: coloured shadows. Of quads and meshes, and not by a factor of what
    /// is behind.
    bool casts = false;

    bool operator==(const TransparentLook&) const = default;
};

struct QuadTransparent {
    glm::dvec3 corner{0};  ///< metres; of an image, the lower left one
    /// Metres, along the whole of its edges; of an image, to the right and up.
    std::array<glm::dvec3, 2> edges{glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)};
    TransparentLook look;

    bool operator==(const QuadTransparent&) const = default;
};

/// A rectangle that stands upright in the picture whatever the camera.
struct BillboardTransparent {
    glm::dvec3 center{0};  ///< metres
    glm::dvec2 size{1};    ///< metres, > 0, across and up the picture
    TransparentLook look;

    bool operator==(const BillboardTransparent&) const = default;
};

/// Each of its triangles that a ray meets is laid over those behind it, from either side.
struct MeshTransparent {
    std::string file;
    std::shared_ptr<const Mesh> mesh;
    glm::dvec3 translate{0};  ///< metres
    double scale = 1;         ///< > 0
    TransparentLook look;

    bool operator==(const MeshTransparent&) const = default;
};

using Transparent = std::variant<QuadTransparent, BillboardTransparent, MeshTransparent>;

/// Whether a blend's factor of what is behind is known without it, so that light can be filtered by
/// it.
FUMAROLE_API bool can_cast(const Blend& blend);

FUMAROLE_API TransparentLook& look_of(Transparent& transparent);
FUMAROLE_API const TransparentLook& look_of(const Transparent& transparent);

/// A place whose view of surfaces, media and sky all around stands for what glossy surfaces near it
/// reflect.
struct LightProbe {
    enum class Parallax {
        none,    ///< all it saw is taken to be far away
        sphere,  ///< all on a sphere of its radius
        box,     ///< all on the faces of a box
    };

    glm::dvec3 position{0};  ///< metres
    double radius = 4;       ///< reach [m], > 0: surfaces within it have light from the probe
    double falloff = 0.5;    ///< share of the radius over which its weight goes to 0, 0..1
    Parallax parallax = Parallax::none;
    glm::dvec3 parallax_min{0};  ///< metres, of the box
    glm::dvec3 parallax_max{1};  ///< metres, > parallax_min
    int size = 128;              ///< edge of each of six captured faces [pixels], 16..512

    bool operator==(const LightProbe&) const = default;
};

/// A latitude-longitude picture of the world's radiance. Row 0 is the zenith (+z), its middle
/// column is the direction +x, and columns run from +y on the left to -y on the right of it: u =
/// 1/2 - atan2(y, x) / 2pi, v = acos(z) / pi. (Blender's convention.)
struct Environment {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> radiance;  ///< W/m^2/sr, row by row from the zenith
};

struct World {
    glm::vec3 radiance{0};  ///< W/m^2/sr, one colour everywhere; not used where there is a map
    std::string environment_file;
    float environment_scale = 1;
    std::shared_ptr<const Environment> environment;

    bool operator==(const World&) const = default;
};

struct Scene {
    glm::uvec2 resolution{480, 270};
    Camera camera;
    World world;
    std::vector<Light> lights;
    std::vector<Medium> media;
    std::vector<Surface> surfaces;
    std::vector<Transparent>
        transparents;  ///< transparents; of two at the same depth the later one is in front
    std::vector<LightProbe>
        probes;       ///< probes; of two that are as near the earlier one counts first
    double time = 0;  ///< time [s] of frame 0; moves drifting noise
    std::vector<CameraKey> camera_path;  ///< keys by ascending time; `camera` is the first one's
    double frames_per_second = 24;
};

/// The camera of a path at a time [s]: on cubics through the keys' positions and targets (Hermite,
/// with the slopes of Catmull and Rom for keys at any times), linear in angle and distances, still
/// before the first key and after the last.
/// @param path not empty, ascending times; projection and `up` are the key's before
FUMAROLE_API Camera camera_at(const std::vector<CameraKey>& path, double time);

/// Whether a renderer that holds one scene may draw the other from another camera: the same media,
/// lights, surfaces, transparents, probes and world, those read from files being the very same.
FUMAROLE_API bool same_content(const Scene& a, const Scene& b);

}  // namespace fumarole
