//! The shader to pipelines: backdrop, surfaces, lattice lines, wireframe, B-rep edges, picking. The formats and layouts
//! that they have in common with targets, buffers and the caller's pipelines.

use ::wgpu::{
    BindGroupLayout, BindingType, BufferBindingType, ColorTargetState, CompareFunction, PrimitiveTopology,
    ShaderStages, TextureFormat, TextureSampleType, TextureViewDimension, VertexAttribute, VertexBufferLayout,
    VertexStepMode, vertex_attr_array,
};
use bytemuck::{Pod, Zeroable};

/// Format of pictures that are read back. Shaders write linear light; the target encodes it to sRGB.
#[cfg(not(target_arch = "wasm32"))]
pub(super) const COLOUR_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Floating point, because with reversed depth its precision matches perspective.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// A record number and a distance per pixel, for picking. Of the formats of integers, OpenGL ES reads back only those
/// of four channels.
pub(super) const PICK_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// A row of a placement, or a point of an edge. Every device reads it in vertex shaders, where some read no buffers.
pub(super) const ROW_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Colour and face of a tile of an instance.
pub(super) const RECORD_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// What is known of an instance.
pub(super) const INSTANCE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Samples per pixel. Every adapter supports 4, which suffices for smooth edges.
pub(super) const SAMPLES: u32 = 4;

/// Position of a vertex in its tile's lattice, in (fractional) cells from the first u-line and the first v-line.
pub(super) type CellPlace = [f32; 2];

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Vertex {
    /// Relative to the part's centre, millimetres.
    pub(super) position: [f32; 3],
    /// Octahedral encoding, -32767 to 32767.
    pub(super) normal: [i16; 2],
}

/// Number of a vertex's tile within its part. On devices that merge tiles only.
pub(super) type TileOfVertex = u32;

/// Per-draw data of one tile of one instance, in a vertex buffer indexed by the draw's instance number.
#[repr(C)]
#[derive(Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Record {
    /// First index. The top bit is set if indices have four bytes.
    pub(super) first_index: u32,
    pub(super) base_vertex: u32,
    pub(super) place: u32,
    pub(super) colour: [u8; 4],
    /// The face within the part.
    pub(super) face: u32,
}

const VERTEX: [VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Snorm16x2];
const RECORD: [VertexAttribute; 5] =
    vertex_attr_array![5 => Uint32, 6 => Uint32, 2 => Uint32, 3 => Unorm8x4, 4 => Uint32];
/// Without what only lines read.
const RECORD_OF_SURFACE: [VertexAttribute; 3] = [RECORD[2], RECORD[3], RECORD[4]];
const TILE: [VertexAttribute; 1] = vertex_attr_array![2 => Uint32];
const CELL: [VertexAttribute; 1] = vertex_attr_array![7 => Float32x2];

/// Layout of a page of vertices.
const VERTICES: VertexBufferLayout<'static> = per_vertex(size_of::<Vertex>(), &VERTEX);
/// Layout of the records.
const RECORDS: VertexBufferLayout<'static> =
    VertexBufferLayout { step_mode: VertexStepMode::Instance, ..per_vertex(size_of::<Record>(), &RECORD) };
/// Layout of the records where surfaces are drawn.
const SURFACE_RECORDS: VertexBufferLayout<'static> =
    VertexBufferLayout { step_mode: VertexStepMode::Instance, ..per_vertex(size_of::<Record>(), &RECORD_OF_SURFACE) };
/// Layout of the numbers of tiles next to a page of vertices.
const TILES: VertexBufferLayout<'static> = per_vertex(size_of::<TileOfVertex>(), &TILE);
/// Layout of the places in the lattice next to a page of vertices.
const CELLS: VertexBufferLayout<'static> = per_vertex(size_of::<CellPlace>(), &CELL);

const fn per_vertex(bytes: usize, attributes: &'static [VertexAttribute]) -> VertexBufferLayout<'static> {
    VertexBufferLayout { array_stride: bytes as u64, step_mode: VertexStepMode::Vertex, attributes }
}

/// What the caller's pipeline needs to draw a [`LiveScene`](super::LiveScene): shader text, vertex buffers, and
/// bind group 0. Scenes on one device have the same.
///
/// The pipeline draws lists of triangles, which are counter-clockwise seen from outside, clockwise where an instance is
/// mirrored. Colour targets, depth format and comparison, samples, and bind groups from 1 on are the caller's.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SurfaceInput {
    /// WGSL to put before the caller's, which may name what it declares: `SceneVertex`, the input of a vertex function;
    /// `scene_surface`, which turns it into a `SceneSurface`: position relative to the eye and in clip space, normal,
    /// linear colour, numbers of instance, part, face and tile; `scene_view`, the camera; `scene_to_eye` and
    /// `scene_linear`. All its names begin with `scene`, `Scene` or `SCENE`. It depends on the device. The scene's own
    /// pipelines have the same text.
    pub wgsl: &'static str,
    /// Layout of bind group 0: camera, placements and records, for vertex and fragment shaders.
    pub bind_group: BindGroupLayout,
    /// Layouts of vertex buffers 0 and 1, of the locations that `SceneVertex` has.
    pub vertex_buffers: [Option<VertexBufferLayout<'static>>; 2],
}

impl SurfaceInput {
    /// That of a device that reads draws from buffers (`indirect`), or of one that merges tiles.
    pub(super) fn new(bind_group: &BindGroupLayout, indirect: bool) -> Self {
        let wgsl = if indirect {
            concat!(include_str!("scene.wgsl"), include_str!("scene_per_tile.wgsl"))
        } else {
            concat!(include_str!("scene.wgsl"), include_str!("scene_merged.wgsl"))
        };
        let vertex_buffers = [Some(VERTICES), Some(if indirect { SURFACE_RECORDS } else { TILES })];
        Self { wgsl, bind_group: bind_group.clone(), vertex_buffers }
    }
}

/// The render pipelines. Bind group 0 is the view in all of them.
#[derive(Clone, Debug)]
pub(super) struct Pipelines {
    /// Bind group 0, and what else surfaces need.
    pub(super) input: SurfaceInput,
    /// Points of edges.
    pub(super) points: BindGroupLayout,
    /// A page of vertices and one of indices. Where tiles are not merged.
    pub(super) triangles: Option<BindGroupLayout>,
    pub(super) backdrop: ::wgpu::RenderPipeline,
    pub(super) surface: ::wgpu::RenderPipeline,
    pub(super) lattice: ::wgpu::RenderPipeline,
    pub(super) wire: ::wgpu::RenderPipeline,
    pub(super) edge: ::wgpu::RenderPipeline,
    pub(super) pick: ::wgpu::RenderPipeline,
}

/// The settings in which the pipelines differ.
struct PipelineKind<'a> {
    vertex: &'a str,
    fragment: &'a str,
    groups: &'a [Option<&'a BindGroupLayout>],
    buffers: &'a [Option<VertexBufferLayout<'a>>],
    topology: PrimitiveTopology,
    depth: CompareFunction,
    target: ColorTargetState,
    samples: u32,
}

impl PipelineKind<'_> {
    fn pipeline(&self, device: &::wgpu::Device, shader: &::wgpu::ShaderModule) -> ::wgpu::RenderPipeline {
        let layout = device.create_pipeline_layout(&::wgpu::PipelineLayoutDescriptor {
            label: Some("trimtess"),
            bind_group_layouts: self.groups,
            immediate_size: 0,
        });
        device.create_render_pipeline(&::wgpu::RenderPipelineDescriptor {
            label: Some(self.vertex),
            layout: Some(&layout),
            vertex: ::wgpu::VertexState {
                module: shader,
                entry_point: Some(self.vertex),
                compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            // Counter-clockwise in front, nothing culled.
            primitive: ::wgpu::PrimitiveState { topology: self.topology, ..::wgpu::PrimitiveState::default() },
            depth_stencil: Some(::wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.depth == CompareFunction::Greater),
                depth_compare: Some(self.depth),
                stencil: ::wgpu::StencilState::default(),
                bias: ::wgpu::DepthBiasState::default(),
            }),
            multisample: ::wgpu::MultisampleState { count: self.samples, ..::wgpu::MultisampleState::default() },
            fragment: Some(::wgpu::FragmentState {
                module: shader,
                entry_point: Some(self.fragment),
                compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(self.target.clone())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

impl Pipelines {
    /// Those for a device that reads draws from buffers (`indirect`), or for one that merges tiles.
    pub(super) fn new(device: &::wgpu::Device, format: TextureFormat, indirect: bool) -> Self {
        let Layouts { view, points, triangles } = Layouts::new(device, indirect);
        let input = SurfaceInput::new(&view, indirect);
        let lines = if indirect { include_str!("lines_per_tile.wgsl") } else { include_str!("lines_merged.wgsl") };
        let shader = device.create_shader_module(::wgpu::ShaderModuleDescriptor {
            label: Some("trimtess"),
            source: ::wgpu::ShaderSource::Wgsl([input.wgsl, include_str!("shader.wgsl"), lines].concat().into()),
        });
        // Only lines have alpha.
        let lit = ColorTargetState { blend: Some(::wgpu::BlendState::ALPHA_BLENDING), ..format.into() };
        let pipeline = |kind: &PipelineKind<'_>| kind.pipeline(device, &shader);
        let surface = PipelineKind {
            vertex: "surface_vertex",
            fragment: "surface_fragment",
            groups: &[Some(&view)],
            buffers: &input.vertex_buffers,
            topology: PrimitiveTopology::TriangleList,
            depth: CompareFunction::Greater,
            target: lit.clone(),
            samples: SAMPLES,
        };
        let line = PipelineKind {
            fragment: "line_fragment",
            depth: CompareFunction::GreaterEqual,
            target: lit.clone(),
            ..surface
        };
        let wire = if indirect {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                groups: &[Some(&view), None, triangles.as_ref()],
                buffers: &[Some(RECORDS)],
                target: lit.clone(),
                ..line
            })
        } else {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                buffers: &[Some(VERTICES)],
                topology: PrimitiveTopology::LineList,
                target: lit.clone(),
                ..line
            })
        };
        Self {
            backdrop: pipeline(&PipelineKind {
                vertex: "backdrop_vertex",
                fragment: "backdrop_fragment",
                buffers: &[],
                depth: CompareFunction::Always,
                target: lit.clone(),
                ..surface
            }),
            pick: pipeline(&PipelineKind {
                fragment: "pick_fragment",
                target: PICK_FORMAT.into(),
                samples: 1,
                ..surface
            }),
            lattice: pipeline(&PipelineKind {
                vertex: "lattice_vertex",
                fragment: "lattice_fragment",
                buffers: &[Some(VERTICES), input.vertex_buffers[1].clone(), Some(CELLS)],
                target: lit.clone(),
                ..line
            }),
            wire,
            edge: pipeline(&PipelineKind {
                vertex: "edge_vertex",
                groups: &[Some(&view), Some(&points)],
                buffers: &[],
                ..line
            }),
            surface: pipeline(&surface),
            input,
            points,
            triangles,
        }
    }
}

/// The bindings of the shaders, group by group.
struct Layouts {
    view: BindGroupLayout,
    points: BindGroupLayout,
    triangles: Option<BindGroupLayout>,
}

impl Layouts {
    fn new(device: &::wgpu::Device, indirect: bool) -> Self {
        let array = BindingType::Buffer {
            ty: BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texels = |sample_type| BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let rows = texels(TextureSampleType::Float { filterable: false });
        let numbers = texels(TextureSampleType::Uint);
        let uniform =
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
        let view = [uniform, uniform, rows, numbers, numbers];
        Self {
            // Records are a vertex buffer where tiles are not merged.
            view: layout(device, if indirect { &view[..4] } else { &view }),
            points: layout(device, &[rows]),
            triangles: indirect.then(|| layout(device, &[array, array])),
        }
    }
}

fn layout(device: &::wgpu::Device, types: &[BindingType]) -> BindGroupLayout {
    let entry = |(binding, &ty): (usize, &BindingType)| {
        let is_storage = matches!(ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. });
        ::wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: if is_storage { ShaderStages::VERTEX } else { ShaderStages::VERTEX_FRAGMENT },
            ty,
            count: None,
        }
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&::wgpu::BindGroupLayoutDescriptor { label: Some("trimtess"), entries: &entries })
}
