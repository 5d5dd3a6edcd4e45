/* OpenMesh's readers of OBJ, OFF and STL behind C callbacks. */
extern "C" {
#include "formats/scan/mesh/openmesh_shim.h"
}

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <istream>
#include <mutex>
#include <new>
#include <streambuf>
#include <vector>

namespace
{

using namespace OpenMesh;

/* Guards OpenMesh's reader objects and its message streams. No other lock is held with it. */
std::mutex reader_mutex;

/* The sink returned an error; err is set. */
struct refused {
    stp_status status;
};

/* The text ended before the reader had everything. */
struct ended {
};

/* A seekable stream over bytes in memory, without a copy. */
class memory_buffer : public std::streambuf
{
  public:
    memory_buffer(const void *data, size_t size)
    {
        char *begin = static_cast<char *>(const_cast<void *>(data));
        setg(begin, begin, begin + size);
    }

  protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir way, std::ios_base::openmode) override
    {
        const off_type base = way == std::ios_base::beg   ? 0
                              : way == std::ios_base::cur ? gptr() - eback()
                                                          : egptr() - eback();
        const off_type target = base + offset;
        if (target < 0 || target > egptr() - eback())
            return pos_type(off_type(-1));
        setg(eback(), eback() + target, egptr());
        return pos_type(target);
    }

    pos_type seekpos(pos_type position, std::ios_base::openmode mode) override
    {
        return seekoff(off_type(position), std::ios_base::beg, mode);
    }
};

/* OpenMesh's readers write into this instead of into a mesh. */
class sink_importer : public IO::BaseImporter
{
  public:
    sink_importer(const stp_openmesh_sink &sink, const std::istream &in, stp_error *err)
        : sink_(sink), in_(in), err_(err)
    {
    }

    VertexHandle add_vertex(const Vec3f &p) override
    {
        check_stream();
        accept(sink_.vertex(sink_.context, p.data(), err_));
        return VertexHandle(static_cast<int>(vertices_++));
    }

    FaceHandle add_face(const VHandles &corners) override
    {
        check_stream();
        indices_.clear();
        for (const VertexHandle &corner : corners)
            indices_.push_back(corner.idx());
        accept(sink_.face(sink_.context, indices_.data(), indices_.size(), err_));
        return FaceHandle(static_cast<int>(faces_++));
    }

    void set_normal(VertexHandle v, const Vec3f &n) override
    {
        accept(sink_.normal(sink_.context, v.idx(), n.data(), err_));
    }

    void set_normal(VertexHandle v, const Vec3d &n) override
    {
        set_normal(v, vector_cast<Vec3f>(n));
    }

    size_t n_vertices() const override
    {
        return vertices_;
    }

    size_t n_faces() const override
    {
        return faces_;
    }

    /* Points do not need what the following functions receive. */
    VertexHandle add_vertex() override
    {
        return add_vertex(Vec3f(0.0f, 0.0f, 0.0f));
    }
    size_t n_edges() const override
    {
        return 0;
    }
    HalfedgeHandle add_edge(VertexHandle, VertexHandle) override
    {
        return HalfedgeHandle();
    }
    FaceHandle add_face(HalfedgeHandle) override
    {
        return FaceHandle();
    }
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec2f> &) override
    {
    }
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec3f> &) override
    {
    }
    void set_face_texindex(FaceHandle, int) override
    {
    }
    void set_point(VertexHandle, const Vec3f &) override
    {
    }
    void set_halfedge(VertexHandle, HalfedgeHandle) override
    {
    }
    void set_texcoord(VertexHandle, const Vec2f &) override
    {
    }
    void set_texcoord(VertexHandle, const Vec3f &) override
    {
    }
    void set_texcoord(HalfedgeHandle, const Vec2f &) override
    {
    }
    void set_texcoord(HalfedgeHandle, const Vec3f &) override
    {
    }
    void set_status(VertexHandle, const Attributes::StatusInfo &) override
    {
    }
    void set_status(HalfedgeHandle, const Attributes::StatusInfo &) override
    {
    }
    void set_status(EdgeHandle, const Attributes::StatusInfo &) override
    {
    }
    void set_status(FaceHandle, const Attributes::StatusInfo &) override
    {
    }
    void set_next(HalfedgeHandle, HalfedgeHandle) override
    {
    }
    void set_face(HalfedgeHandle, FaceHandle) override
    {
    }
    void request_face_texcoords2D() override
    {
    }
    void set_color(VertexHandle, const Vec3uc &) override
    {
    }
    void set_color(VertexHandle, const Vec4uc &) override
    {
    }
    void set_color(VertexHandle, const Vec3f &) override
    {
    }
    void set_color(VertexHandle, const Vec4f &) override
    {
    }
    void set_color(EdgeHandle, const Vec3uc &) override
    {
    }
    void set_color(EdgeHandle, const Vec4uc &) override
    {
    }
    void set_color(EdgeHandle, const Vec3f &) override
    {
    }
    void set_color(EdgeHandle, const Vec4f &) override
    {
    }
    void set_color(FaceHandle, const Vec3uc &) override
    {
    }
    void set_color(FaceHandle, const Vec4uc &) override
    {
    }
    void set_color(FaceHandle, const Vec3f &) override
    {
    }
    void set_color(FaceHandle, const Vec4f &) override
    {
    }
    void set_normal(FaceHandle, const Vec3f &) override
    {
    }
    void set_normal(FaceHandle, const Vec3d &) override
    {
    }
    void add_texture_information(int, std::string) override
    {
    }

  private:
    /* The readers believe counts and do not check the stream. Without this check a cut file gives
     * stale values. */
    void check_stream() const
    {
        if (in_.fail())
            throw ended();
    }

    static void accept(stp_status status)
    {
        if (status != STP_OK)
            throw refused{status};
    }

    const stp_openmesh_sink &sink_;
    const std::istream &in_;
    stp_error *err_;
    size_t vertices_ = 0, faces_ = 0;
    std::vector<int64_t> indices_;
};

bool read_silently(const stp_openmesh_input &input, const stp_openmesh_sink &sink, stp_error *err)
{
    const std::lock_guard<std::mutex> lock(reader_mutex);
    memory_buffer buffer(input.data, input.size);
    std::istream stream(&buffer);
    sink_importer importer(sink, stream, err);
    IO::Options options = IO::Options::VertexNormal;
    if (input.binary)
        options += IO::Options::Binary;
    omerr().disable();
    omlog().disable();
    omout().disable();
    return IO::IOManager().read(stream, input.extension, importer, options);
}

} // namespace

extern "C" stp_status stp_openmesh_read(const stp_openmesh_input *input,
                                        const stp_openmesh_sink *sink, stp_error *err)
{
    try {
        if (read_silently(*input, *sink, err))
            return STP_OK;
        return stp_error_set(err, STP_CORRUPT,
                             "%s: OpenMesh cannot read it as %s: export it again, or as PLY",
                             input->path, input->extension);
    } catch (const refused &refusal) {
        return refusal.status;
    } catch (const ended &) {
        return stp_error_set(err, STP_CORRUPT,
                             "%s: ends at byte %zu before all that it declares: the file was cut; "
                             "copy or export it again",
                             input->path, input->size);
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY,
                             "%s: no memory for a mesh file of %zu bytes: close other programs or "
                             "convert it to PLY without faces",
                             input->path, input->size);
    } catch (...) {
        return stp_error_set(err, STP_CORRUPT,
                             "%s: OpenMesh failed on it as %s: export it again, or as PLY",
                             input->path, input->extension);
    }
}
