# Derives the polynomials and the table of sine_cosine.cc. Needs mpmath.
from mpmath import mp, mpf, sin, cos, sqrt, matrix, lu_solve, pi, floor, factorial
mp.prec = 300
B = (pi/4 + mpf(2)**-20)**2   # z = r^2 range
def series(f, z):
    # f='s': (sin r - r)/r^3 ; f='c': (cos r - 1 + z/2)/z^2, by series to avoid cancellation
    t = mpf(0)
    for k in range(40):
        if f=='s': t += (-1)**(k+1) * z**k/factorial(2*k+3)
        else: t += (-1)**k * z**k/factorial(2*k+4)
    return t
def weight(f, z):
    # error of the value: r^3 * dP relative to sin r ~ r ; z^2 dQ relative to cos
    if f=='s':
        return z  # relative to r
    return z*z
def remez(f, n):
    # minimise max |w (P - F)| on (0,B], P degree n-1: n+1 points
    xs=[B*(1-__import__('mpmath').cos(pi*(i+mpf(1)/2)/(n+1)))/2 for i in range(n+1)]
    for it in range(30):
        A=matrix(n+1,n+1); b=matrix(n+1,1)
        for i,x in enumerate(xs):
            for j in range(n): A[i,j]=x**j
            A[i,n]=(-1)**i/weight(f,x)
            b[i]=series(f,x)
        s=lu_solve(A,b); c=[s[j] for j in range(n)]
        e=lambda x: weight(f,x)*(sum(c[j]*x**j for j in range(n))-series(f,x))
        # extrema on grid
        N=1500; g=[B*(i)/N for i in range(1,N+1)]; ev=[e(x) for x in g]
        ext=[]
        i=0
        while i<N:
            j=i; best=i
            while j<N and (ev[j]>=0)==(ev[i]>=0):
                if abs(ev[j])>abs(ev[best]): best=j
                j+=1
            ext.append(g[best]); i=j
        if len(ext)>n+1: ext=ext[-(n+1):]
        if len(ext)<n+1: break
        d=max(abs(a-b_) for a,b_ in zip(ext,xs)); xs=ext
        if d<B/N*1.5: break
    m=max(abs(v) for v in ev)
    return c,m
from mpmath import log
for f,n in (('s',6),('c',6)):
    c,m=remez(f,n)
    print(f, 'minimax error 2^%.2f'%float(log(m,2)))
    cd=[float(x) for x in c]
    e=lambda x: weight(f,x)*(sum(mpf(cd[j])*x**j for j in range(n))-series(f,x))
    m2=max(abs(e(B*i/2000)) for i in range(1,2001))
    print(' after rounding 2^%.2f'%float(log(m2,2)))
    for x in cd: print('   ', x.hex(), repr(x))
def chop(v,bits):
    import mpmath
    m,e=mpmath.frexp(v); return mpmath.ldexp(floor(mpmath.ldexp(m,bits)),int(e)-bits)
p=pi/2; p1=chop(p,33); p2=chop(p-p1,33); p3=float(p-p1-p2)
print(float(p1).hex(), float(p2).hex(), p3.hex(), float(2/pi).hex())
print('pi/2 hi lo', float(pi/2).hex(), float(pi/2-mpf(float(pi/2))).hex())
mp.prec=1600
t=2/pi; words=[]
for i in range(20):
    t=t*2**64; w=int(floor(t)); words.append(w); t-=w
print(', '.join('0x%016xu'%w for w in words))
