//! The shader to pipelines: backdrop, surfaces, lattice lines, wireframe, B-rep edges, picking.

use super::formats::{DEPTH_FORMAT, PICK_FORMAT, SAMPLES};
use super::layout::{CellPlace, Record, TileOfVertex, Vertex};
use ::wgpu::{
    BindGroupLayout, BindingType, BufferBindingType, ColorTargetState, CompareFunction, PrimitiveTopology,
    ShaderStages, TextureFormat, TextureSampleType, TextureViewDimension, VertexAttribute, VertexBufferLayout,
    VertexStepMode,
};

/// The render pipelines. Bind group 0 is the view in all of them.
#[derive(Clone, Debug)]
pub(super) struct Pipelines {
    /// Globals and places.
    pub(super) view: BindGroupLayout,
    /// Points of edges.
    pub(super) points: BindGroupLayout,
    /// A page of vertices and one of indices. Where tiles are not merged.
    pub(super) triangles: Option<BindGroupLayout>,
    /// Colours and first rows. Where tiles are merged.
    pub(super) records: Option<BindGroupLayout>,
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
        let of_draws = if indirect { include_str!("per_tile.wgsl") } else { include_str!("merged.wgsl") };
        let shader = device.create_shader_module(::wgpu::ShaderModuleDescriptor {
            label: Some("trimtess"),
            source: ::wgpu::ShaderSource::Wgsl([include_str!("shader.wgsl"), of_draws].concat().into()),
        });
        let Layouts { view, points, triangles, records } = Layouts::new(device, indirect);
        let vertex = ::wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x2];
        let vertex = per_vertex(size_of::<Vertex>(), &vertex);
        let record = ::wgpu::vertex_attr_array![2 => Uint32, 3 => Uint32, 4 => Uint32, 5 => Unorm8x4];
        let record =
            VertexBufferLayout { step_mode: VertexStepMode::Instance, ..per_vertex(size_of::<Record>(), &record) };
        let tile = ::wgpu::vertex_attr_array![7 => Uint32];
        let tile = per_vertex(size_of::<TileOfVertex>(), &tile);
        let cells = ::wgpu::vertex_attr_array![6 => Float32x2];
        let cells = per_vertex(size_of::<CellPlace>(), &cells);
        // Only lines have alpha.
        let lit = ColorTargetState { blend: Some(::wgpu::BlendState::ALPHA_BLENDING), ..format.into() };
        let pipeline = |kind: &PipelineKind<'_>| kind.pipeline(device, &shader);
        let of_tiles = [Some(&view), None, None, records.as_ref()];
        let groups = &of_tiles[..if indirect { 1 } else { 4 }];
        let tiles = [Some(vertex.clone()), Some(if indirect { record.clone() } else { tile.clone() })];
        let surface = PipelineKind {
            vertex: "surface_vertex",
            fragment: "surface_fragment",
            groups,
            buffers: &tiles,
            topology: PrimitiveTopology::TriangleList,
            depth: CompareFunction::Greater,
            target: lit.clone(),
            samples: SAMPLES,
        };
        let line = PipelineKind {
            fragment: "line_fragment",
            depth: CompareFunction::GreaterEqual,
            target: lit.clone(),
            groups: &[Some(&view)],
            ..surface
        };
        let wire = if indirect {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                groups: &[Some(&view), None, triangles.as_ref()],
                buffers: &[Some(record)],
                target: lit.clone(),
                ..line
            })
        } else {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                buffers: &[Some(vertex.clone())],
                topology: PrimitiveTopology::LineList,
                target: lit.clone(),
                ..line
            })
        };
        Self {
            backdrop: pipeline(&PipelineKind {
                vertex: "backdrop_vertex",
                fragment: "backdrop_fragment",
                groups: &[Some(&view)],
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
                buffers: &[Some(vertex), tiles[1].clone(), Some(cells)],
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
            view,
            points,
            triangles,
            records,
        }
    }
}

/// The bindings of the shaders, group by group.
struct Layouts {
    view: BindGroupLayout,
    points: BindGroupLayout,
    triangles: Option<BindGroupLayout>,
    records: Option<BindGroupLayout>,
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
        let globals =
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
        Self {
            view: layout(device, &[globals, rows]),
            points: layout(device, &[rows]),
            triangles: indirect.then(|| layout(device, &[array, array])),
            records: (!indirect).then(|| layout(device, &[rows, texels(TextureSampleType::Uint)])),
        }
    }
}

fn per_vertex(bytes: usize, attributes: &[VertexAttribute]) -> VertexBufferLayout<'_> {
    VertexBufferLayout { array_stride: bytes as u64, step_mode: VertexStepMode::Vertex, attributes }
}

fn layout(device: &::wgpu::Device, types: &[BindingType]) -> BindGroupLayout {
    let entry = |(binding, &ty): (usize, &BindingType)| {
        let is_uniform = matches!(ty, BindingType::Buffer { ty: BufferBindingType::Uniform, .. });
        let fragments = if is_uniform { ShaderStages::FRAGMENT } else { ShaderStages::NONE };
        ::wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: ShaderStages::VERTEX | fragments,
            ty,
            count: None,
        }
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&::wgpu::BindGroupLayoutDescriptor { label: Some("trimtess"), entries: &entries })
}
