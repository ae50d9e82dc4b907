#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/lattice.h"
#include "light/lattice_ways.h"
#include "light/sky_share.h"
#include "light/steps.h"
#include "shared/draw_params.h"
#include "shared/field_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// Light that is not direct, at the nodes of a lattice: the world's, what media scatter a second
// time and on, and what they emit.

namespace fumarole::light {

/// What light is carried through.
struct FieldMedium {
    gl::Defines defines;   ///< the media's, the lights' and those of the volumes that dim lights
    bool colored = false;  ///< extinction is
    int ways = 0;          ///< kNearWays or kAllWays, that surfaces are met along
    glm::vec3 albedo{1};   ///< where there is no medium
    /// Media differ in g. Then nodes may send out less than they take in: what they take in beside
    /// another medium has the g of a mean of both, which brings as much too much through it.
    bool mixed_g = false;
    bool scatters = true;  ///< true if light scatters; else no more is asked than how it is dimmed
    bool glows = false;    ///< some medium emits
    bool dims = true;      ///< media dim light
    bool marched = true;   ///< some medium's optical depth has no closed form
    bool closed = false;   ///< some medium's has
    bool amid = false;     ///< those reach beyond the lattice
    bool scatters_again = false;  ///< light that the media scatter is followed: then they scatter
    /// Share of the extinction that is scattered straight on, and is taken for none:
    /// glsl/light/forward_peak.glsl.
    float straight_on = 0;
    bool sights = false;  ///< how far nodes see is asked for: take_sights()
    bool rim = false;     ///< besides near surfaces light is looked up at SURFACES_RIM
    bool thick = false;   ///< light hardly gets from node to node: it is kept with more digits
    /// Points that are no lights here: the first of them, and the one after the last.
    glm::ivec2 left_out{0};
    Bounds hole;    ///< metres, world: what FieldOutput::of_media is without; empty: nothing
    Bounds bounds;  ///< metres, world: of all of them
    Bounds ends;    ///< metres, world: MediaSet::ends()
    const World* world = nullptr;  ///< the world whose light comes in
    const gl::Texture* extinction =
        nullptr;  ///< extinction of the marched media, where no volume dims lights
    /// Metres, world: where it is told how much of what a way stands for surfaces hide; elsewhere
    /// they hide all of it or nothing.
    Bounds sky_box;
    /// Binds the media, the lights and their volumes anew, after a pause.
    std::function<void()> bind_again;
};

/// How far scattering is followed.
struct FieldOrders {
    /// Orders after the first, as asked for; or those of a cycle, after which the rest is guessed:
    /// FIELD_KEPT_ORDERS at most.
    int count = 0;
    int cycles = 0;  ///< each goes on from the guess of the one before; 0: nothing is guessed
    /// They start from what a coarser lattice has, and a node's own light is taken as if it had
    /// gone on for ever: in thick media light gets as far with fewer of them.
    bool coarse_first = false;
    float straight_on = 0;  ///< FieldMedium's
    bool operator==(const FieldOrders&) const = default;
};

/// Light at the nodes of another lattice, as coefficients: what arrives, or what is scattered
/// there.
struct OtherLight {
    const gl::Texture* light = nullptr;  ///< alpha of the first: 0 in nodes inside of surfaces
    const gl::Texture* walls =
        nullptr;  ///< walls between the lattice's nodes, as take_walls(); of what arrives
    shared::LatticeParams at{};  ///< the lattice, for an eye amid the one that takes it
    int bands = 0;
};

/// What orders of scattering start from.
struct OrdersStart {
    enum class From {
        lights,     ///< what is scattered of the light that comes first
        scattered,  ///< what is scattered elsewhere, as RadianceField::fill() gave it: nested
                    ///< iteration (Briggs and others 2000, "A Multigrid Tutorial", ch. 3)
        arrived,    ///< all that arrived by an earlier filling but what came straight from lights
        arrived_here,  ///< that, as this lattice has it: sums() stay as they are
    };
    From from = From::lights;
    OtherLight light = {};  ///< of all but the first
};

/// Light of the media's own that a lattice's nodes are to have besides the world's.
struct FieldLight {
    int ways = 0;             ///< kNearWays or kAllWays, that it comes along
    bool along_rays = false;  ///< instead: from each node to all parts of the media
    /// What they scatter, as RadianceField::fill() gave it for another lattice; empty: nothing.
    const gl::Texture* scattered = nullptr;
    shared::LatticeParams at{};  ///< the lattice, for an eye amid this one
    int bands = 0;               ///< number of bands that it was filled for
};

/// What comes to a lattice's media besides lights and their own.
struct FieldInput {
    const gl::Texture* world = nullptr;   ///< coefficients of the world's light; null: none
    const OtherLight* bounced = nullptr;  ///< what surfaces send on
    /// What media beyond the lattice's faces send in, as nodes of another have it that holds them.
    const OtherLight* beyond = nullptr;
    OrdersStart start = {};
};

/// What is filled: coefficients at the nodes.
struct FieldOutput {
    const gl::Texture& field;  ///< all light that is not direct
    /// What is scattered, of the radiance that a thick medium would have; empty where no order is
    /// followed.
    gl::Texture* scattered = nullptr;
    const gl::Texture* of_media = nullptr;  ///< of the field what media scatter and emit
};

/// Discrete ordinates (Chandrasekhar 1950): each order of scattering is carried along a few
/// directions through the whole lattice at once, and gathered at the nodes as spherical harmonics,
/// whose bands the phase function weighs for the next order. The lattice is of cubes, and the
/// directions are those in which nodes see each other: a light's way meets nodes alone, and nothing
/// is smeared. With the weights of a cubature of their points (Lebedev 1976, 26 points, of degree
/// 7; 74 points, of degree 11, by the same equations) they sum products of the harmonics that are
/// kept exactly, and no energy is made.
class RadianceField {
public:
    RadianceField(const gl::Device& device, gl::ProgramCache& programs);
    ~RadianceField();
    RadianceField(const RadianceField&) = delete;
    RadianceField& operator=(const RadianceField&) = delete;

    /// Takes up a lattice: what the media are at its nodes, and what surfaces hide from them.
    /// Media, lights and their volumes are bound, here and until end(). What is done in Steps may
    /// be left for other work, and what is given to them stays until they are done.
    /// @param bounces surfaces send light on: light_surfaces() and bounce() are called
    void begin(const FieldLattice& lattice, FieldMedium medium, const surface::SurfaceSet& surfaces,
               bool bounces = false);

    /// Coefficients, bands^2 layers each, of the world's light, summed over kNearWays or
    /// kAllWays directions: `dimmed` by the media, and `clear`: hidden by surfaces alone. Either
    /// may be null. `light`, if any, is added to what is dimmed.
    Steps fill_world(int ways, int bands, const gl::Texture* clear, const gl::Texture* dimmed,
                     const FieldLight* light = nullptr);

    /// Adds what the media send to what fill_world() gave for `dimmed`, in the place of what was
    /// added before, and the light of the last bounce(), or of one or two before it.
    Steps add_light(int bands, const FieldLight& light, const gl::Texture& dimmed, int taken_back);

    /// Works out what surfaces send on of all light that reaches them now, as if they were
    /// Lambertian. What glsl/scene/irradiance.glsl needs is bound but for the media's part, and the
    /// lines for it are `shading`.
    void light_surfaces(const gl::Defines& shading, const surface::SurfaceSet& surfaces);
    /// Carries that along `ways` directions, dimmed by the media: its coefficients, bands^2 layers,
    /// alone, and with the world's light that fill_world() gave. Any may be null.
    Steps bounce(int ways, int bands, const gl::Texture* alone, const gl::Texture* clear,
                 const gl::Texture* dimmed);
    /// After the last of them: the same for surfaces to look up. What surfaces within the lattice
    /// send, and media, `light`, where add_light() had it, is gathered along many ways from each
    /// node, which are others at the next: the few that light is carried along show as stripes.
    /// @param dimmed may be null
    Steps smooth(int ways, int bands, const FieldLight* light, const gl::Texture& clear,
                 const gl::Texture* dimmed);
    [[nodiscard]] const gl::Texture& walls() const;
    /// What was bound before a pause, but for what each dispatch binds itself.
    void bind_again();
    /// Between begin() and end().
    [[nodiscard]] bool is_open() const { return filling_ != nullptr; }

    /// Coefficients, bands^2 layers of them, of light that is not direct. What media emit and
    /// scatter again is gathered along `ways`, kNearWays or kAllWays, directions, as the world's
    /// was: what a set of them takes from the one is what it gives to the other.
    Steps fill(int ways, int bands, FieldOrders orders, FieldInput from, FieldOutput to);

    /// Makes what fill() gave of what is scattered that of the whole phase function and extinction,
    /// where it was without what is scattered straight on. Before end().
    void make_whole(int bands, const gl::Texture& scattered);

    /// How far from each node the nearest surface lies along each of the lattice's axes, down and
    /// then up, a layer each; empty where there is none. Before end().
    [[nodiscard]] gl::Texture take_walls();
    /// How far each node sees in each octant around it, a layer each; where FieldMedium::sights.
    /// Before end().
    [[nodiscard]] gl::Texture take_sights();
    [[nodiscard]] const gl::Texture& sights() const;
    /// Works them out. `light`, as fill_world() gave it, tells which nodes lie inside of surfaces.
    void find_sights(const gl::Texture& light);
    /// Whether some of the surfaces may stand between the lattice's nodes. Before end().
    [[nodiscard]] bool has_walls(const surface::SurfaceSet& surfaces) const
    {
        return !within(surfaces).empty();
    }

    /// What surfaces leave at the nodes of points in a fire: light/fire_seen.comp. What these are
    /// is bound. `light`, as fill_world() gave it, tells which nodes lie inside of surfaces.
    void see_fire(const gl::Texture& light, const gl::Texture& to);

    /// Frees what was there for filling.
    void end();

    /// Mean radiance over what scatters that each order brought, the light that has not been
    /// scattered first [W/m^2/sr]. Waits for the GPU.
    [[nodiscard]] std::vector<glm::vec3> sums() const;
    /// How much a further order would change of what is scattered, rms, of all; none where nothing
    /// was guessed. Waits for the GPU.
    [[nodiscard]] std::optional<float> left_over() const;

    /// Lets go of what is kept of surfaces from one lattice to the next.
    void forget();

    /// Lattices that surfaces were drawn into so far.
    [[nodiscard]] int drawings() const { return drawings_; }

private:
    struct Filling;
    struct Drawn;
    struct Batch;
    /// Nodes that light is asked for at: all, or those that media are near to, or that surfaces
    /// look it up at, if it is known which.
    enum class Nodes { all, listed, looked_up };
    /// At which of the lattice's faces media end.
    void take_ends();
    [[nodiscard]] GLenum light_format() const;  ///< of a way's light, as pack_light() makes it
    [[nodiscard]] gl::Texture make(const char* label, int layers) const;
    [[nodiscard]] glm::ivec3 ways_size(int ways) const;
    [[nodiscard]] gl::Texture make_ways(const char* label, int ways, GLenum format) const;
    /// Coefficients of light at nodes that are not listed: where no medium looks it up it need not
    /// be known, but must not be taken for the inside of a surface.
    void clear_unlisted(const gl::Texture& light) const;
    /// Of what is scattered into ways: none at nodes that are not listed.
    [[nodiscard]] gl::Texture make_sources(int ways) const;
    void draw(const surface::SurfaceSet& surfaces);
    void put_side_by_side(const gl::Texture& crossed);
    void draw_walls(const surface::SurfaceSet& surfaces);
    void share_sky(const surface::SurfaceSet& surfaces);
    void keep_walls();
    void find_clearance();
    void wait_for_drawing();
    void take_faces(const surface::SurfaceSet& surfaces);
    void find_emission(const surface::SurfaceSet& surfaces);
    /// Numbers of the surfaces that shine and are too small for a lattice's faces.
    std::vector<std::size_t> find_lamps(const surface::SurfaceSet& surfaces);
    /// What they send, as what `to` begins with. False: nothing.
    bool begin_by_lamps(int bands, const gl::Texture& to);
    void copy(const gl::Texture& from, const gl::Texture& to) const;
    void draw_beyond(const gl::Defines& shading, const surface::SurfaceSet& surfaces);
    void draw_along_axes(const surface::SurfaceSet& surfaces, const gl::Texture& to,
                         const gl::Defines& variant, int ways, int parts = 1);
    [[nodiscard]] gl::Defines bounce_defines() const;
    void even_out(int bands, gl::Texture& light);
    Steps carry_bounced(int ways, int bands, const gl::Defines& defines, const gl::Texture& to);
    void take_over(const OtherLight& other, int bands, const gl::Texture& to);
    /// Sets the course of a way, and gives how many lines along it meet the lattice, across.
    glm::ivec2 set_way(int slot, glm::dvec3 wi);
    /// Along the lines of the first `ways` ways that are set, into the images that are bound.
    /// @param parts lines on each side of the square that one stands for
    void draw_lines(const surface::SurfaceSet& surfaces,
                    const std::vector<surface::SurfaceSet::Instance>& drawn, int ways,
                    glm::ivec2 lines, const gl::Framebuffer& target, int parts = 1);
    /// The surfaces of which some lies within the lattice, and some beyond it.
    [[nodiscard]] std::vector<surface::SurfaceSet::Instance>
    within(const surface::SurfaceSet& surfaces) const;
    [[nodiscard]] std::vector<surface::SurfaceSet::Instance>
    beyond(const surface::SurfaceSet& surfaces) const;
    [[nodiscard]] gl::Defines dimmed_defines() const;
    void sample_medium();
    [[nodiscard]] std::vector<Batch> batches(int set) const;
    void set_batch(const Batch& batch);
    /// What is gathered: the world's light as surfaces, or media too, let it through; else that
    /// which the media send on.
    enum class Of { clear, dimmed, field, means };
    /// @param dimmed beside what is clear: takes what media let through too
    void gather(int bands, bool adds, Of of, const gl::Texture& ways, const gl::Texture& to,
                Nodes nodes = Nodes::all, const gl::Texture* dimmed = nullptr);
    Steps add(const FieldLight& light, int bands, const gl::Texture& to);
    /// The same along rays from each node through all of the media.
    Steps add_along_rays(const FieldLight& light, int bands, const gl::Texture& to);
    /// What is scattered, or arrives, there along each way of the batch.
    [[nodiscard]] gl::Texture spread(const OtherLight& light, int ways,
                                     Nodes nodes = Nodes::listed);
    /// What comes in along each way of the batch; empty: nothing does.
    [[nodiscard]] gl::Texture come_in(const OtherLight* beyond, int ways);
    /// How many ways the batch has, where that is one of the usual two numbers.
    void add_ways(gl::Defines& defines) const;
    /// What each way of a node takes in, for each node to send out as much light as it takes in.
    void find_taken();
    void add_taken(gl::Defines& defines) const;
    void walk(const char* file, const gl::Defines& defines, int ways);
    void carry_world(const Batch& batch, bool means);
    [[nodiscard]] gl::Defines extinction_defines() const;
    /// What a sweep carries, and what it tells of it.
    struct Sweep {
        bool emits = false;                   ///< what media emit
        const gl::Texture* source = nullptr;  ///< what they scatter; null: nothing
        const gl::Texture* comes = nullptr;   ///< what comes in at the faces; null: nothing
        bool means = false;                   ///< means between nodes, for what is scattered next
        bool looked = false;                  ///< for places between nodes
    };
    void sweep(const Sweep& what);
    /// What is scattered into each of the kNearWays directions once `orders` have been followed.
    /// @param direct what comes straight from lights, where orders start from what arrived before
    Steps scatter(int bands, FieldOrders orders, const gl::Texture& first,
                  const gl::Texture& direct, OrdersStart start, gl::Texture& source);
    [[nodiscard]] gl::Texture own_light();
    /// Weights of the orders that are kept, as light/field_rest.comp gives them.
    void weigh(const gl::Texture& kept, int orders);
    void finish(int bands, const gl::Texture& light, const gl::Texture* world,
                const gl::Texture* total, const gl::Texture& to, Nodes nodes = Nodes::all,
                bool holed = false);
    void write_block();
    void bind_image(GLuint unit, const gl::Texture& texture, GLenum access,
                    GLenum format = GL_RGBA32F) const;
    void dispatch(const char* file, gl::Defines defines, glm::ivec3 threads,
                  glm::ivec3 group) const;
    void dispatch_nodes(const char* file, const gl::Defines& defines) const;
    /// Over those nodes alone that media are near to, if it is known which.
    void dispatch_listed(const char* file, const gl::Defines& defines) const;
    void dispatch_over(const gl::Buffer& nodes, const char* file, gl::Defines defines) const;
    void dispatch_at(Nodes nodes, const char* file, const gl::Defines& defines) const;
    void list_nodes();
    void list_looked_up(const surface::SurfaceSet& surfaces);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::FieldParams> block_;
    gl::UniformBuffer<shared::DrawParams> draw_block_;
    gl::Framebuffer framebuffer_, beyond_framebuffer_;
    std::unique_ptr<SkyShare> sky_share_;  ///< once it is asked for
    shared::FieldParams params_{};
    std::unique_ptr<Filling> filling_;
    std::unique_ptr<Drawn> drawn_;
    gl::Texture sums_, guess_;
    int orders_ = 0, drawings_ = 0;
};

}  // namespace fumarole::light
